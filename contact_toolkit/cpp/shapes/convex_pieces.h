// ConvexPieces: a solid as a union of convex hulls, under the same hierarchy as a mesh's facets.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shapes/convex_leaves.h"

namespace contact_toolkit {

// Immutable once built; shared between threads freely.
class ConvexPieces {
 public:
  // Piece i is the hull of points first[i] to first[i + 1]; first has one entry more than there are
  // pieces. Throws std::invalid_argument on an empty piece or a coordinate that is not finite.
  ConvexPieces(std::vector<Vec3> points, std::vector<std::int32_t> first);

  int size() const { return static_cast<int>(first_.size()) - 1; }
  std::span<const Vec3> piece(int i) const {
    return {points_.data() + first_[i], points_.data() + first_[i + 1]};
  }
  ConvexLeaves leaves() const { return {bvh_, points_, first_}; }
  Vec3 lower() const { return bvh_.origin - bvh_.half_extent; }
  Vec3 upper() const { return bvh_.origin + bvh_.half_extent; }

 private:
  std::vector<Vec3> points_;
  std::vector<std::int32_t> first_;
  Bvh bvh_;
};

}  // namespace contact_toolkit
