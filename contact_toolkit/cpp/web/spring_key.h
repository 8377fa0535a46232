// A facet-web spring's key: its two features, each as two bits of kind and thirty of index.
#pragma once

#include <cstdint>

#include "query/witness/facet_pair.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

inline std::uint64_t KeyOf(const FeaturePair& features) { return features.key(); }

inline FeaturePair FeaturesOf(std::uint64_t key) {
  const auto feature = [](std::uint32_t code) {
    return Feature{static_cast<FeatureKind>(code >> 30),
                   static_cast<std::int32_t>(code & 0x3FFFFFFF)};
  };
  return {feature(static_cast<std::uint32_t>(key >> 32)), feature(static_cast<std::uint32_t>(key))};
}

}  // namespace contact_toolkit
