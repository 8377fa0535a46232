// Depth-first search over pairs of nodes and slices of time for the pairs of leaves that come
// within reach during the motion. What reach means, and what to do with a pair of leaves, is the
// query's.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "convex_leaves.h"
#include "motion.h"
#include "simd/swept_kernels.h"
#include "tolerances.h"

namespace contact_toolkit {

// Query provides
//   double reach(const TimeSlice&) const    pairs further apart in the slice matter no more;
//   negative: none Vec3 direction() const                  a unit vector in A likely to separate
//   leaves; or zero void Visit(slot_a, slot_b, const TimeSlice&, double bound)    `bound`: they are
//   no closer
template <typename Query>
class SweptSearch {
 public:
  // split_time: halve slices in which B's boxes travel further than they are large.
  SweptSearch(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion, bool split_time,
              Query* query)
      : a_(A.bvh()),
        b_(B.bvh()),
        facets_(A.mesh() != nullptr && B.mesh() != nullptr),
        slices_(motion),
        split_time_(split_time),
        query_(*query) {}

  void Run() {
    stack_.push_back({0, 0, 0, 0});
    while (!stack_.empty()) {
      const Item item = stack_.back();
      stack_.pop_back();
      if (Wanted(item.squared_bound, slices_[item.slice])) Open(item);
    }
  }

 private:
  struct Item {
    float squared_bound;
    std::int32_t a, b, slice;
  };

  bool Wanted(float squared_bound, const TimeSlice& slice) const {
    const double reach = query_.reach(slice);
    return reach >= 0 && squared_bound <= reach * reach;
  }

  void Open(const Item& item) {
    const BvhNode &a = a_.nodes[item.a], &b = b_.nodes[item.b];
    const SweptCull& cull = CullOf(item.slice);
    alignas(32) float bound[kBvhWidth * kBvhWidth];
    const float furthest = kernels_.box_bounds(a, b, cull, bound);
    if (split_time_ && IsLong(item, furthest, std::max(LargestHalf(a), LargestHalf(b)))) {
      const int first = slices_.Halves(item.slice);
      stack_.push_back({item.squared_bound, item.a, item.b, first + 1});
      stack_.push_back({item.squared_bound, item.a, item.b, first});
    } else if (a.bottom() && b.bottom()) {
      Visit(item, a, b, bound);
    } else {
      Descend(item, a, b, bound);
    }
  }

  bool IsLong(const Item& item, float furthest, float largest) const {
    const TimeSlice& slice = slices_[item.slice];
    const double duration = slice.end - slice.begin;
    return duration > kShortestSlice &&
           (furthest > kLongWay * largest || duration * slices_.motion().angle() > kWideTurn);
  }

  void Descend(const Item& item, const BvhNode& a, const BvhNode& b, const float* bound) {
    const auto base = static_cast<std::ptrdiff_t>(stack_.size());
    const TimeSlice& slice = slices_[item.slice];
    const auto push = [&](float least, std::int32_t next_a, std::int32_t next_b) {
      if (Wanted(least, slice)) stack_.push_back({least, next_a, next_b, item.slice});
    };
    if (a.bottom()) {
      for (int j = 0; j < b.count; ++j) {
        push(*std::min_element(bound + 8 * j, bound + 8 * j + a.count), item.a, b.child[j]);
      }
    } else if (b.bottom()) {
      for (int k = 0; k < a.count; ++k) {
        float least = bound[k];
        for (int j = 1; j < b.count; ++j) least = std::min(least, bound[8 * j + k]);
        push(least, a.child[k], item.b);
      }
    } else {
      for (int j = 0; j < b.count; ++j) {
        for (int k = 0; k < a.count; ++k) push(bound[8 * j + k], a.child[k], b.child[j]);
      }
    }
    // Nearest last, so that it is opened first; ties by index keep the order fixed.
    std::sort(stack_.begin() + base, stack_.end(), [](const Item& x, const Item& y) {
      if (x.squared_bound != y.squared_bound) return x.squared_bound > y.squared_bound;
      return x.a != y.a ? x.a > y.a : x.b > y.b;
    });
  }

  void Visit(const Item& item, const BvhNode& a, const BvhNode& b, const float* bound) {
    const TimeSlice slice = slices_[item.slice];
    std::uint64_t pairs = 0;
    for (int j = 0; j < b.count; ++j) {
      for (int k = 0; k < a.count; ++k) {
        if (Wanted(bound[8 * j + k], slice)) pairs |= std::uint64_t{1} << (8 * j + k);
      }
    }
    if (facets_ && pairs != 0) {
      const Vec3 n = query_.direction();
      const float direction[3]{static_cast<float>(n.x), static_cast<float>(n.y),
                               static_cast<float>(n.z)};
      pairs = kernels_.cull_facets(a_.blocks[a.block], b_.blocks[b.block], CullOf(item.slice),
                                   direction, static_cast<float>(query_.reach(slice)), pairs);
    }
    std::pair<float, int> order[kBvhWidth * kBvhWidth];
    int count = 0;
    for (; pairs != 0; pairs &= pairs - 1) {
      const int lanes = __builtin_ctzll(pairs);
      order[count++] = {bound[lanes], lanes};
    }
    std::sort(order, order + count);
    for (int i = 0; i < count; ++i) {
      const auto [least, lanes] = order[i];
      if (!Wanted(least, slice)) continue;
      query_.Visit(a.child[lanes % kBvhWidth], b.child[lanes / kBvhWidth], slice, std::sqrt(least));
    }
  }

  static float LargestHalf(const BvhNode& node) {
    float largest = 0;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < node.count; ++k) largest = std::max(largest, node.half[i][k]);
    }
    return largest;
  }

  const SweptCull& CullOf(int slice) {
    if (slice >= static_cast<int>(culls_.size())) culls_.resize(slice + 1);
    if (!culls_[slice]) {
      culls_[slice] = std::make_unique<SweptCull>(a_, b_, slices_.motion(), slices_[slice]);
    }
    return *culls_[slice];
  }

  const Bvh &a_, &b_;
  const bool facets_;
  TimeSlices slices_;
  const bool split_time_;
  Query& query_;
  const SweptKernels& kernels_ = ActiveSweptKernels();
  std::vector<std::unique_ptr<SweptCull>> culls_;
  std::vector<Item> stack_;
};

}  // namespace contact_toolkit
