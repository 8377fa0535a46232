// Stiffness, and the stretch that goes with it, that anchors lost because the features under a
// contact changed, for the springs on neighbouring features to take over.
#pragma once

#include <utility>
#include <vector>

#include "contact/anchors.h"
#include "web/spring_web.h"

namespace contact_toolkit {

class StretchExchange {
 public:
  // `kept`: how much of its stiffness each anchor still has.
  StretchExchange(const SpringWeb& web, const AnchorSet& anchors, const std::vector<double>& kept);

  struct Share {
    const Anchor* anchor;
    double stiffness;
  };

  // Takes up to `wanted` of stiffness from anchors whose features share a vertex, on A and on B,
  // with the features of `key`. The result lasts until the next call.
  const std::vector<Share>& Take(std::uint64_t key, double wanted);

 private:
  struct Offer {
    const Anchor* anchor;
    double stiffness;
    FeatureVertices vertices;
  };

  const SpringWeb& web_;
  std::vector<Offer> offers_;
  std::vector<std::pair<std::int32_t, std::int32_t>> by_vertex_;  // vertex of A, index of an offer
  std::vector<Share> taken_;
};

}  // namespace contact_toolkit
