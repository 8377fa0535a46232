// Hash of a point by its bits, for tables of exactly coincident points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "vec.h"

namespace contact_toolkit {

struct VertexHash {
  std::size_t operator()(const Vec3& v) const {
    std::size_t hash = 0;
    for (int i = 0; i < 3; ++i) {
      const double value = v[i] + 0.0;  // -0.0 and 0.0 weld
      std::uint64_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      hash = (hash ^ bits) * 0x9e3779b97f4a7c15ull;
      hash ^= hash >> 32;
    }
    return hash;
  }
};

}  // namespace contact_toolkit
