// How far the facets below the nodes of a hierarchy reach along a direction. Along the line between
// the closest points known so far this bounds distances far better than boxes do, where a flat face
// lies askew to the boxes' axes and every box sticks out of it.
#pragma once

#include <cstdint>
#include <vector>

#include "shapes/bvh.h"

namespace contact_toolkit {

class NodeExtents {
 public:
  // Forgets what was computed for another direction (or hierarchy), without clearing anything. The
  // direction is in the mesh's frame; what is returned is the one that counts, as it is rounded.
  Vec3 Start(const Bvh& bvh, const Vec3& direction);

  // A lower bound of direction · (x - origin) over the facets below a node; remembered.
  float Least(std::int32_t node);

 private:
  struct Entry {
    std::uint32_t direction = 0;  // the one it was computed for
    float least = 0;
  };

  float LeastBelow(const BvhNode& node, int levels);

  const Bvh* bvh_ = nullptr;
  float n_[3];
  std::uint32_t direction_ = 0;
  std::vector<Entry> entries_;
};

}  // namespace contact_toolkit
