#include "node_extents.h"

#include <algorithm>
#include <cmath>

namespace contact_toolkit {
namespace {

// Levels below a node that are looked into before its descendants' boxes stand in for their facets.
constexpr int kLevels = 2;

}  // namespace

void NodeExtents::Start(const Bvh& bvh, const float (&direction)[3]) {
  bvh_ = &bvh;
  std::copy_n(direction, 3, n_);
  if (entries_.size() < bvh.nodes.size()) entries_.resize(bvh.nodes.size());
  if (++direction_ == 0) std::fill(entries_.begin(), entries_.end(), Entry{}), direction_ = 1;
}

float NodeExtents::Least(std::int32_t node) {
  Entry& entry = entries_[node];
  if (entry.direction != direction_) entry = {direction_, LeastBelow(bvh_->nodes[node], kLevels)};
  return entry.least;
}

float NodeExtents::LeastBelow(const BvhNode& node, int levels) {
  float least[kBvhWidth];
  if (node.bottom()) {
    const FacetBlock& block = bvh_->blocks[node.block];
    for (int k = 0; k < kBvhWidth; ++k) {
      float at[3];
      for (int c = 0; c < 3; ++c) {
        const auto& v = block.vertex[c];
        at[c] = n_[0] * v[0][k] + n_[1] * v[1][k] + n_[2] * v[2][k];
      }
      least[k] = std::min(std::min(at[0], at[1]), at[2]);
    }
  } else if (levels > 0) {
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
  return *std::min_element(least, least + node.count);
}

}  // namespace contact_toolkit
