#include "shapes/node_extents.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace contact_toolkit {
namespace {

// Levels below a node that are looked into before its descendants' boxes stand in for their facets.
// More would see less stick out of the boxes, but fetch eight times as many nodes.
constexpr int kLevels = 1;

}  // namespace

Vec3 NodeExtents::Start(const Bvh& bvh, const Vec3& direction) {
  bvh_ = &bvh;
  const Vec3 local = bvh.axes * direction;
  for (int i = 0; i < 3; ++i) n_[i] = static_cast<float>(local[i]);
  if (entries_.size() < bvh.nodes.size()) entries_.resize(bvh.nodes.size());
  if (++direction_ == 0) std::fill(entries_.begin(), entries_.end(), Entry{}), direction_ = 1;
  return Transpose(bvh.axes) * Vec3{n_[0], n_[1], n_[2]};
}

float NodeExtents::Least(std::int32_t node) {
  Entry& entry = entries_[node];
  if (entry.direction != direction_) entry = {direction_, LeastBelow(bvh_->nodes[node], kLevels)};
  return entry.least;
}

float NodeExtents::LeastBelow(const BvhNode& node, int levels) {
  // Unused lanes repeat a used one, or hold no less.
  alignas(32) float least[kBvhWidth];
  if (node.bottom() && !bvh_->blocks.empty()) {
    const FacetBlock& block = bvh_->blocks[node.block];
    for (int k = 0; k < kBvhWidth; ++k) {
      float at[3];
      for (int c = 0; c < 3; ++c) {
        const auto& v = block.vertex[c];
        at[c] = n_[0] * v[0][k] + n_[1] * v[1][k] + n_[2] * v[2][k];
      }
      least[k] = std::min(std::min(at[0], at[1]), at[2]);
    }
  } else if (levels > 0 && !node.bottom()) {
    std::fill_n(least, kBvhWidth, std::numeric_limits<float>::infinity());
    for (int k = 0; k < node.count; ++k) {
      const BvhNode& child = bvh_->nodes[node.child[k]];
      least[k] = child.bottom() ? Least(node.child[k]) : LeastBelow(child, levels - 1);
    }
  } else {
    for (int k = 0; k < kBvhWidth; ++k) {
      least[k] = 0;
      for (int i = 0; i < 3; ++i) {
        least[k] += n_[i] * node.center[i][k] - std::abs(n_[i]) * std::max(node.half[i][k], 0.0f);
      }
    }
  }
  for (int width = kBvhWidth / 2; width > 0; width /= 2) {
    for (int k = 0; k < width; ++k) least[k] = std::min(least[k], least[k + width]);
  }
  return least[0];
}

}  // namespace contact_toolkit
