// Least distance by branch and bound, the best distance so far being the bound.
//
// Depth first, the nearest boxes first, is the cheapest where boxes lie apart. Where they overlap
// every bound is zero and says nothing: then the boxes whose middles are close go first, and when
// some leaves in a row have brought nothing better the search goes on elsewhere, now where the
// bound is least, now anywhere, so that no wrong turn costs much.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/scratch.h"
#include "base/tolerances.h"
#include "query/witness/facet_pair.h"
#include "query/witness/witness.h"
#include "shapes/node_extents.h"

namespace contact_toolkit {
namespace {

// [-] Weight of the squared distance of the boxes' middles beside that of the boxes, where these
// overlap.
constexpr float kMiddles = 0.003f;
// Leaves in a row without a better pair before the search goes on elsewhere: so many at first, and
// one more each time it was in vain, up to the most.
constexpr int kPatience = 4, kMostPatience = 32;
// The first leaves, while the bound is poor, are left after each, and measure their nearest facets
// before the rest is culled with what these gave.
constexpr int kFirstLeaves = 16, kFewFacets = 8;

// Nodes, by the order they are to be opened in.
struct Waiting {
  float bound;  // [m²] they are no closer than that
  std::int32_t a, b;
};

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

class Search {
 public:
  // Looks for pairs up to upper_bound [m], until one is no farther apart than `enough` [m].
  Search(const PosedPair& pair, double upper_bound, double enough)
      : pair_(pair),
        A_(pair.A.bvh()),
        B_(pair.B.bvh()),
        enough_(enough * enough),
        best_(std::max(upper_bound * upper_bound * (1 + 1e-9), upper_bound > 0 ? kTiny : 0)),
        stack_(Scratch<std::vector<Waiting>>([] {})),
        extents_a_(Extents(0)),
        extents_b_(Extents(1)) {}

  void Run() {
    stack_.clear();
    stack_.push_back({0, 0, 0});
    while (!stack_.empty() && !Done()) {
      const Waiting next = stack_.back();
      stack_.pop_back();
      if (!(next.bound < best_) || Apart(next)) continue;
      const BvhNode &a = A_.nodes[next.a], &b = B_.nodes[next.b];
      if (a.bottom() && b.bottom()) {
        MeasureLeaf(a, b);
      } else {
        Descend(next, a, b);
      }
    }
  }

  bool found() const { return found_.count > 0; }

  ClosestPair Result(double upper_bound) const {
    ClosestPair closest;
    if (!found()) return closest;
    const Witness w = WitnessOf(pair_, found_, 0);
    if (w.distance > upper_bound) return closest;
    const FeaturePair features = FeaturesOf(pair_, found_, 0);
    closest = {w.distance,
               w.p_ACa,
               w.p_ACb,
               w.normal_A,
               A_.slot_facet[found_.slot_a[0]],
               B_.slot_facet[found_.slot_b[0]],
               features.a,
               features.b};
    return closest;
  }

 private:
  static NodeExtents& Extents(int side) {
    return Scratch<std::array<NodeExtents, 2>>([] {})[side];
  }

  float Limit() const { return static_cast<float>(std::min(best_, 1e38)); }
  bool Done() const { return found() && best_ <= enough_; }

  void Descend(const Waiting& from, const BvhNode& a, const BvhNode& b) {
    alignas(32) float bound[64], order[64];
    pair_.kernels.box_orders(a, b, pair_.cull, Limit(), kMiddles, bound, order);
    // A bottom node stays while the other side descends: the least of its facets stand for it.
    if (a.bottom()) {
      for (int j = 0; j < b.count; ++j) KeepLeast(8 * j, 1, a.count, bound, order);
    } else if (b.bottom()) {
      for (int k = 0; k < a.count; ++k) KeepLeast(k, 8, b.count, bound, order);
    }
    const int width = a.bottom() ? 1 : a.count, height = b.bottom() ? 1 : b.count;
    Ranking ranking;
    for (int j = 0; j < height; ++j) {
      for (int k = 0; k < width; ++k) {
        if (bound[8 * j + k] < best_) ranking.Add(order[8 * j + k], 8 * j + k);
      }
    }
    ranking.Sort();
    // The first last, so that it is opened first.
    for (int i = ranking.count(); i-- > 0;) {
      const int pair = ranking.pair(i);
      stack_.push_back({bound[pair], a.bottom() ? from.a : a.child[pair & 7],
                        b.bottom() ? from.b : b.child[pair >> 3]});
    }
  }

  // Of `count` pairs from the first on, `stride` apart: leaves the least of each at the first.
  static void KeepLeast(int first, int stride, int count, float* bound, float* order) {
    for (int i = 1; i < count; ++i) {
      bound[first] = std::min(bound[first], bound[first + stride * i]);
      order[first] = std::min(order[first], order[first + stride * i]);
    }
  }

  void MeasureLeaf(const BvhNode& a, const BvhNode& b) {
    alignas(32) float bound[64], order[64];
    const bool early = ++leaves_ <= kFirstLeaves;
    const double before = best_;
    if (early) {
      pair_.kernels.box_orders(a, b, pair_.cull, Limit(), kMiddles, bound, order);
    } else {
      pair_.kernels.box_bounds(a, b, pair_.cull, Limit(), bound);
    }
    std::uint64_t bits = 0;
    for (int j = 0; j < b.count; ++j) bits |= ((std::uint64_t{1} << a.count) - 1) << (8 * j);
    bits = Cull(a, b, bound, bits);
    while (early && std::popcount(bits) > 3 * kFewFacets / 2) {
      Ranking ranking;
      for (std::uint64_t rest = bits; rest != 0; rest &= rest - 1) {
        const int pair = std::countr_zero(rest);
        ranking.Add(order[pair], pair);
      }
      const std::uint64_t few = ranking.First(kFewFacets);
      const double best_before = best_;
      Measure(a, b, few);
      bits &= ~few;
      if (best_ < best_before) bits = Cull(a, b, bound, bits);
    }
    Measure(a, b, bits);
    GoElsewhere(early, best_ < before);
  }

  // Facet pairs that may be closer than the best.
  std::uint64_t Cull(const BvhNode& a, const BvhNode& b, const float* bound, std::uint64_t bits) {
    std::uint64_t near = 0;
    for (; bits != 0; bits &= bits - 1) {
      const int pair = std::countr_zero(bits);
      near |= std::uint64_t{bound[pair] < best_} << pair;
    }
    if (near == 0) return 0;
    return pair_.kernels.cull_by_axes(A_.blocks[a.block], B_.blocks[b.block], pair_.cull,
                                      static_cast<float>(std::sqrt(best_)), near);
  }

  void Measure(const BvhNode& a, const BvhNode& b, std::uint64_t bits) {
    chunk_.count = 0;
    for (; bits != 0; bits &= bits - 1) {
      const int pair = std::countr_zero(bits);
      chunk_.slot_a[chunk_.count] = a.child[pair & 7];
      chunk_.slot_b[chunk_.count++] = b.child[pair >> 3];
    }
    MeasureFacetPairs(pair_, &chunk_);
    for (int k = 0; k < chunk_.count; ++k) {
      if (!(chunk_.distance[k] * chunk_.distance[k] < best_)) continue;
      best_ = chunk_.distance[k] * chunk_.distance[k];
      found_.count = 1;
      found_.slot_a[0] = chunk_.slot_a[k];
      found_.slot_b[0] = chunk_.slot_b[k];
      found_.CopyMeasured(0, chunk_, k);
    }
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

  // Whether two nodes lie farther apart than the best distance along the line of the best pair.
  bool Apart(const Waiting& nodes) {
    if (!found()) return false;
    if (std::sqrt(best_) < stale_below_) Aim();
    const double apart = double{extents_a_.Least(nodes.a)} + extents_b_.Least(nodes.b) - offset_;
    return apart > 0 && apart * apart > best_ * length_;
  }

  // Takes the line of the best pair, from B towards A, for the direction of the extents. Extents
  // are no larger than the bodies, so single precision does; the way between them is in double.
  void Aim() {
    const double distance = std::sqrt(best_);
    stale_below_ = distance - kStaleAim * std::min({distance, A_.size, B_.size});
    const Vec3 line = Normalized({found_.normal[0][0], found_.normal[1][0], found_.normal[2][0]});
    const Vec3 along = extents_a_.Start(A_, line);
    extents_b_.Start(B_, -(Transpose(pair_.X_AB.R) * along));
    length_ = SquaredNorm(along) * (1 + kTouching);
    offset_ = Dot(along, pair_.X_AB * B_.origin - A_.origin) + kCullingSlack * (A_.size + B_.size) +
              kTouching * pair_.size;
  }

  // [m²] A bound whose square underflows must still admit a distance of zero.
  static constexpr double kTiny = 1e-300;
  const PosedPair& pair_;
  const Bvh &A_, &B_;
  const double enough_;  // [m²]
  double best_;          // [m²]
  FacetPairs chunk_, found_;
  std::vector<Waiting>& stack_;
  int leaves_ = 0, in_vain_ = 0, patience_ = kPatience;
  bool anywhere_ = false;
  std::uint32_t lot_ = 1;
  double stale_below_ = std::numeric_limits<double>::infinity();  // [m] then aim anew
  double offset_ = 0;                                             // [m] of B's origin, and slack
  double length_ = 1;  // squared, of the direction as rounded
  NodeExtents& extents_a_;
  NodeExtents& extents_b_;
};

}  // namespace

ClosestPair FindDistance(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                         double upper_bound) {
  const PosedPair pair(A, B, X_AB);
  Search search(pair, upper_bound, 0);
  search.Run();
  return search.Result(upper_bound);
}

double LeastDistance(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                     double enough) {
  const PosedPair pair(A, B, X_AB);
  Search search(pair, std::numeric_limits<double>::infinity(), std::max(enough, 0.0));
  search.Run();
  const double distance = search.Result(std::numeric_limits<double>::infinity()).distance;
  return distance - kCertain * (A.diagonal() + B.diagonal() + distance);
}

bool Intersects(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB) {
  const PosedPair pair(A, B, X_AB);
  const double touching = kTouching * pair.size;
  Search search(pair, touching, touching);
  search.Run();
  return search.found();
}

}  // namespace contact_toolkit
