// Finds the pairs of leaves of two hierarchies that come within a distance (the query's reach) of
// each other during a motion: depth-first over pairs of nodes, each with an interval of time that
// is halved where the boxes' bound over all of it is too coarse. A query supplies the reach and
// examines the pairs of leaves.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/tolerances.h"
#include "kernels/swept_kernels.h"
#include "math/motion.h"
#include "shapes/convex_leaves.h"

namespace contact_toolkit {

// Pairs of leaves to examine, the nearest boxes first.
struct LeafPairs {
  struct Pair {
    double squared_bound;  // they are no closer than that during the slice
    std::int32_t slot_a, slot_b;
  };
  int count = 0;
  std::array<Pair, kBvhWidth * kBvhWidth> pair;
};

// [-] Weight of the squared distance of the boxes' middles beside that of the boxes, as many of
// these overlap.
inline constexpr float kSweptMiddles = 0.003f;

// By the bounds, and by the middles in the middle of the slice.
template <typename Bound>
void OrderByMiddles(const BvhNode& a, const BvhNode& b, const SweptCull& cull, const Bound* bound,
                    float* order) {
  for (int j = 0; j < b.count; ++j) {
    float c[3];
    for (int i = 0; i < 3; ++i) {
      c[i] = 0.5f * (cull.p_begin[i] + cull.p_end[i]);
      for (int k = 0; k < 3; ++k) c[i] += cull.R[i][k] * b.center[k][j];
    }
    for (int k = 0; k < kBvhWidth; ++k) {
      const float x = a.center[0][k] - c[0], y = a.center[1][k] - c[1], z = a.center[2][k] - c[2];
      order[kBvhWidth * j + k] =
          static_cast<float>(bound[kBvhWidth * j + k]) + kSweptMiddles * (x * x + y * y + z * z);
    }
  }
}

// What Query provides:
//
//   double squared_reach(const TimeSlice&) const;
// Pairs further apart matter no more in the slice; negative: no pair does.
//
//   Vec3 direction() const;
// A unit vector in A that is likely to separate leaves, or zero.
//
//   void Visit(const LeafPairs&, const TimeSlice&);
template <typename Query>
class SweptSearch {
 public:
  // The motion is searched up to `end`.
  SweptSearch(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion, double end,
              Query* query)
      : a_(A.bvh()),
        b_(B.bvh()),
        facets_(A.mesh() != nullptr && B.mesh() != nullptr),
        slices_(motion, end),
        query_(*query) {}

  void Run() {
    stack_.reserve(kBvhWidth * kBvhWidth);
    stack_.push_back({0, 0, 0, 0});
    while (!stack_.empty()) {
      const Item item = stack_.back();
      stack_.pop_back();
      if (item.squared_bound > query_.squared_reach(slices_[item.slice])) continue;
      Open(item);
    }
  }

 private:
  struct Item {
    double squared_bound;
    std::int32_t a, b, slice;
  };

  void Open(const Item& item) {
    const BvhNode &a = a_.nodes[item.a], &b = b_.nodes[item.b];
    const SweptCull& cull = CullOf(item.slice);
    const double reach = query_.squared_reach(slices_[item.slice]);
    alignas(32) float bound[kBvhWidth * kBvhWidth];
    std::uint64_t near;
    const float furthest = kernels_.box_bounds(a, b, cull, static_cast<float>(reach), bound, &near);
    if (IsLong(item, furthest, std::max(LargestHalf(a), LargestHalf(b)))) {
      const int first = slices_.Halves(item.slice);
      stack_.push_back({item.squared_bound, item.a, item.b, first + 1});
      stack_.push_back({item.squared_bound, item.a, item.b, first});
    } else if (cull.coarse) {
      double fine[kBvhWidth * kBvhWidth] = {};
      near = 0;
      for (int j = 0; j < b.count; ++j) {
        for (int k = 0; k < a.count; ++k) {
          fine[8 * j + k] = cull.SquaredBound(a, k, b, j);
          near |= std::uint64_t{fine[8 * j + k] <= reach} << (8 * j + k);
        }
      }
      VisitOrDescend(item, a, b, fine, near);
    } else {
      VisitOrDescend(item, a, b, bound, near);
    }
  }

  // near: bit 8 j + k is set where child k of a may be within reach of child j of b.
  template <typename Bound>
  void VisitOrDescend(const Item& item, const BvhNode& a, const BvhNode& b, const Bound* bound,
                      std::uint64_t near) {
    if (near == 0) return;
    if (a.bottom() && b.bottom()) {
      Visit(item, a, b, bound, near);
    } else {
      Descend(item, a, b, bound, near);
    }
  }

  bool IsLong(const Item& item, float furthest, float largest) const {
    const TimeSlice& slice = slices_[item.slice];
    const double duration = slice.end - slice.begin;
    return duration > kShortestSlice &&
           (furthest > kLongWay * largest || duration * slices_.motion().angle() > kWideTurn);
  }

  template <typename Bound>
  void Descend(const Item& item, const BvhNode& a, const BvhNode& b, const Bound* bound,
               std::uint64_t near) {
    alignas(32) float order[kBvhWidth * kBvhWidth];
    OrderByMiddles(a, b, CullOf(item.slice), bound, order);
    struct Next {
      float order;
      std::int32_t index;  // into items: these are larger, and need not be moved about
    };
    Next next[kBvhWidth * kBvhWidth];
    Item items[kBvhWidth * kBvhWidth];
    int count = 0;
    const auto add = [&](Bound least, float first, std::int32_t next_a, std::int32_t next_b) {
      next[count] = {first, count};
      items[count++] = {least, next_a, next_b, item.slice};
    };
    // A bottom node stays while the other side descends.
    if (a.bottom()) {
      for (int j = 0; j < b.count; ++j) {
        const auto least = [&](const auto* row) {
          return *std::min_element(row + 8 * j, row + 8 * j + a.count);
        };
        if ((near >> (8 * j) & 0xff) != 0) add(least(bound), least(order), item.a, b.child[j]);
      }
    } else if (b.bottom()) {
      for (int k = 0; k < a.count; ++k) {
        const auto least = [&](const auto* column) {
          auto least = column[k];
          for (int j = 1; j < b.count; ++j) least = std::min(least, column[8 * j + k]);
          return least;
        };
        if ((near >> k & 0x0101010101010101) != 0) {
          add(least(bound), least(order), a.child[k], item.b);
        }
      }
    } else {
      for (; near != 0; near &= near - 1) {
        const int bit = __builtin_ctzll(near);
        add(bound[bit], order[bit], a.child[bit % kBvhWidth], b.child[bit / kBvhWidth]);
      }
    }
    std::sort(next, next + count, [](const Next& x, const Next& y) { return x.order < y.order; });
    // The first last, so that it is opened first.
    for (int i = count; i-- > 0;) stack_.push_back(items[next[i].index]);
  }

  template <typename Bound>
  void Visit(const Item& item, const BvhNode& a, const BvhNode& b, const Bound* bound,
             std::uint64_t bits) {
    const TimeSlice& slice = slices_[item.slice];
    if (facets_) {
      const Vec3 n = a_.axes * query_.direction();
      const float direction[3]{static_cast<float>(n.x), static_cast<float>(n.y),
                               static_cast<float>(n.z)};
      const double reach = std::sqrt(query_.squared_reach(slice));
      bits = kernels_.cull_facets(a_.blocks[a.block], b_.blocks[b.block], CullOf(item.slice),
                                  direction, static_cast<float>(reach), bits);
      if (bits == 0) return;
    }
    LeafPairs pairs;
    for (; bits != 0; bits &= bits - 1) {
      const int lanes = __builtin_ctzll(bits);
      pairs.pair[pairs.count++] = {bound[lanes], a.child[lanes % kBvhWidth],
                                   b.child[lanes / kBvhWidth]};
    }
    std::sort(pairs.pair.begin(), pairs.pair.begin() + pairs.count,
              [](const LeafPairs::Pair& x, const LeafPairs::Pair& y) {
                return x.squared_bound < y.squared_bound;
              });
    query_.Visit(pairs, slice);
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
  Query& query_;
  const SweptKernels& kernels_ = ActiveSweptKernels();
  std::vector<std::unique_ptr<SweptCull>> culls_;
  std::vector<Item> stack_;
};

}  // namespace contact_toolkit
