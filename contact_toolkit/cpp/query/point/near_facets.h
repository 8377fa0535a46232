// For each of some points, the facets that can be closest to it after it has moved by no more than
// a given way: a distance changes no faster than the point moves.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "query/point/point_distance.h"

namespace contact_toolkit {

class NearFacets {
 public:
  // Appends the next point's facets. Where there are many nothing is kept.
  void Add(const Bvh& bvh, const Vec3& p, double motion) {
    FindNearFacets(bvh, p, 2 * motion, scratch_.empty() ? -1 : scratch_[0].slot, &scratch_);
    if (scratch_.size() <= kMost) facets_.insert(facets_.end(), scratch_.begin(), scratch_.end());
    last_.push_back(static_cast<std::int32_t>(facets_.size()));
  }

  // Keeps nothing for the next point.
  void Skip() { last_.push_back(static_cast<std::int32_t>(facets_.size())); }

  // Nearest first; empty where they have to be searched for.
  std::span<const NearFacet> Of(std::int32_t point) const {
    const std::int32_t first = point > 0 ? last_[point - 1] : 0;
    return {facets_.data() + first, facets_.data() + last_[point]};
  }

 private:
  static constexpr std::size_t kMost = 64;  // more take as long as a search

  std::vector<NearFacet> facets_, scratch_;
  std::vector<std::int32_t> last_;
};

}  // namespace contact_toolkit
