// Branch and bound over pairs of nodes for what is closest, the best distance so far being the
// bound.
//
// Depth first, the nearest boxes first, is the cheapest where boxes lie apart. Where they overlap
// every bound is zero and says nothing: then the boxes whose middles are close go first, and when
// some leaves in a row have brought nothing better the search goes on elsewhere, now where the
// bound is least, now anywhere, so that no wrong turn costs much.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/scratch.h"
#include "shapes/bvh.h"

namespace contact_toolkit {

// [-] Weight of the squared distance of the boxes' middles beside that of the boxes, where these
// overlap.
inline constexpr float kMiddles = 0.003f;

// The 64 child pairs of two nodes as sortable numbers: the order first, which is not negative, then
// which pair it is.
class Ranking {
 public:
  void Add(float order, int pair) {
    ranks_[count_++] =
        std::uint64_t{std::bit_cast<std::uint32_t>(order)} << 32 | static_cast<unsigned>(pair);
  }
  void Sort() { std::sort(ranks_.begin(), ranks_.begin() + count_); }
  // The `few` pairs that come first, a bit each.
  std::uint64_t First(int few) {
    few = std::min(few, count_);
    std::nth_element(ranks_.begin(), ranks_.begin() + few - 1, ranks_.begin() + count_);
    std::uint64_t bits = 0;
    for (int i = 0; i < few; ++i) bits |= std::uint64_t{1} << pair(i);
    return bits;
  }
  int count() const { return count_; }
  int pair(int i) const { return static_cast<int>(ranks_[i] & 63); }

 private:
  int count_ = 0;
  std::array<std::uint64_t, kBvhWidth * kBvhWidth> ranks_;
};

// What Query provides; pair 8 j + k is child k of a with child j of b:
//
//   double squared_reach() const;
// [m²] Pairs farther apart matter no more.
//
//   bool Done() const;
// Whether nothing closer is wanted.
//
//   bool Apart(std::int32_t node_a, std::int32_t node_b);
// Whether two nodes are known to be out of reach; may always be false.
//
//   std::uint64_t Bounds(const BvhNode& a, const BvhNode& b, float bound[64]);
//   std::uint64_t Orders(const BvhNode& a, const BvhNode& b, float bound[64], float order[64]);
// Lower bounds of squared distances, and the bits of pairs they leave within reach; and numbers in
// whose order to look at the pairs.
//
//   std::uint64_t Cull(const BvhNode& a, const BvhNode& b, std::uint64_t pairs);
// Clears the bits of pairs of leaves that are out of reach.
//
//   void Measure(const BvhNode& a, const BvhNode& b, std::uint64_t pairs);
template <class Query>
class NearestSearch {
 public:
  NearestSearch(const Bvh& A, const Bvh& B, Query* query)
      : A_(A), B_(B), query_(*query), stack_(Scratch<std::vector<Waiting>>([] {})) {}

  void Run() {
    stack_.clear();
    stack_.push_back({0, 0, 0});
    while (!stack_.empty() && !query_.Done()) {
      const Waiting next = stack_.back();
      stack_.pop_back();
      if (!(next.bound < query_.squared_reach()) || query_.Apart(next.a, next.b)) continue;
      const BvhNode &a = A_.nodes[next.a], &b = B_.nodes[next.b];
      if (a.bottom() && b.bottom()) {
        VisitLeaf(a, b);
      } else {
        Descend(next, a, b);
      }
    }
  }

 private:
  // Leaves in a row without a better pair before the search goes on elsewhere: so many at first,
  // and one more each time it was in vain, up to the most.
  static constexpr int kPatience = 4, kMostPatience = 32;
  // The first leaves, while the bound is poor, are left after each, and measure their nearest pairs
  // before the rest is culled with what these gave.
  static constexpr int kFirstLeaves = 16, kFewPairs = 8;

  // Nodes, by the order they are to be opened in.
  struct Waiting {
    float bound;  // [m²] they are no closer than that
    std::int32_t a, b;
  };

  void Descend(const Waiting& from, const BvhNode& a, const BvhNode& b) {
    alignas(32) float bound[64], order[64];
    std::uint64_t near = query_.Orders(a, b, bound, order);
    // A bottom node stays while the other side descends: the least of its leaves stand for it.
    if (a.bottom()) {
      near = KeepLeast(near, b.count, 8, a.count, 1, bound, order);
    } else if (b.bottom()) {
      near = KeepLeast(near, a.count, 1, b.count, 8, bound, order);
    }
    Ranking ranking;
    for (; near != 0; near &= near - 1) {
      const int pair = std::countr_zero(near);
      ranking.Add(order[pair], pair);
    }
    ranking.Sort();
    // The first last, so that it is opened first.
    for (int i = ranking.count(); i-- > 0;) {
      const int pair = ranking.pair(i);
      stack_.push_back({bound[pair], a.bottom() ? from.a : a.child[pair & 7],
                        b.bottom() ? from.b : b.child[pair >> 3]});
    }
  }

  // Of `count` pairs from each of `rows` pairs on, `stride` and `pitch` apart: leaves the least at
  // the first. Returns the bits of these where any of theirs is set.
  static std::uint64_t KeepLeast(std::uint64_t near, int rows, int pitch, int count, int stride,
                                 float* bound, float* order) {
    std::uint64_t firsts = 0;
    for (int first = 0; first < rows * pitch; first += pitch) {
      for (int pair = first + stride; pair < first + count * stride; pair += stride) {
        bound[first] = std::min(bound[first], bound[pair]);
        order[first] = std::min(order[first], order[pair]);
        near |= (near >> pair & 1) << first;
      }
      firsts |= std::uint64_t{1} << first;
    }
    return near & firsts;
  }

  void VisitLeaf(const BvhNode& a, const BvhNode& b) {
    alignas(32) float bound[64], order[64];
    const bool early = ++leaves_ <= kFirstLeaves;
    const double before = query_.squared_reach();
    std::uint64_t bits = early ? query_.Orders(a, b, bound, order) : query_.Bounds(a, b, bound);
    if (bits != 0) bits = query_.Cull(a, b, bits);
    while (early && std::popcount(bits) > 3 * kFewPairs / 2) {
      Ranking ranking;
      for (std::uint64_t rest = bits; rest != 0; rest &= rest - 1) {
        const int pair = std::countr_zero(rest);
        ranking.Add(order[pair], pair);
      }
      const std::uint64_t few = ranking.First(kFewPairs);
      const double reach_before = query_.squared_reach();
      query_.Measure(a, b, few);
      bits &= ~few;
      if (query_.squared_reach() < reach_before) bits = CullAgain(a, b, bound, bits);
    }
    if (bits != 0) query_.Measure(a, b, bits);
    GoElsewhere(early, query_.squared_reach() < before);
  }

  // Pairs of leaves that may still be closer than the best.
  std::uint64_t CullAgain(const BvhNode& a, const BvhNode& b, const float* bound,
                          std::uint64_t bits) {
    const double reach = query_.squared_reach();
    std::uint64_t near = 0;
    for (; bits != 0; bits &= bits - 1) {
      const int pair = std::countr_zero(bits);
      near |= std::uint64_t{bound[pair] < reach} << pair;
    }
    return near == 0 ? 0 : query_.Cull(a, b, near);
  }

  // After a leaf, puts what is to be opened next on top of the stack, if it is not what lies there.
  void GoElsewhere(bool early, bool better) {
    in_vain_ = better ? 0 : in_vain_ + 1;
    if (better) patience_ = kPatience;
    if (!(early || in_vain_ >= patience_) || stack_.size() < 2) return;
    if (!early) patience_ = std::min(patience_ + 1, kMostPatience);
    in_vain_ = 0;
    anywhere_ = !early && !anywhere_;
    // The nearest of all that wait, or any; of those that are as near, any.
    std::size_t chosen = stack_.size() - 1;
    float least = std::numeric_limits<float>::infinity();
    std::uint32_t highest_lot = 0;
    for (std::size_t i = 0; i < stack_.size(); ++i) {
      if (!anywhere_ && stack_[i].bound > least) continue;
      lot_ = lot_ * 1664525u + 1013904223u;  // the same in every search
      const bool nearer = !anywhere_ && stack_[i].bound < least;
      if (nearer || lot_ > highest_lot) chosen = i, highest_lot = lot_;
      least = stack_[i].bound;
    }
    std::swap(stack_.back(), stack_[chosen]);
  }

  const Bvh &A_, &B_;
  Query& query_;
  std::vector<Waiting>& stack_;
  int leaves_ = 0, in_vain_ = 0, patience_ = kPatience;
  bool anywhere_ = false;
  std::uint32_t lot_ = 1;
};

}  // namespace contact_toolkit
