// Least distance by branch and bound: nearest boxes first, best distance so far as the bound.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "facet_pair.h"
#include "node_extents.h"
#include "scratch.h"
#include "tolerances.h"
#include "witness.h"

namespace contact_toolkit {
namespace {

class Search {
 public:
  Search(const PosedPair& pair, double upper_bound)
      : pair_(pair),
        best_(std::max(upper_bound * upper_bound * (1 + 1e-9), upper_bound > 0 ? kTiny : 0)),
        extents_a_(Extents(0)),
        extents_b_(Extents(1)) {}

  void Visit(std::int32_t index_a, std::int32_t index_b) {
    if (Apart(index_a, index_b)) return;
    const Bvh &A = pair_.A.bvh(), &B = pair_.B.bvh();
    const BvhNode &a = A.nodes[index_a], &b = B.nodes[index_b];
    alignas(32) float bound[64];
    pair_.kernels.box_bounds(a, b, pair_.cull, bound);
    if (a.bottom() && b.bottom()) {
      MeasureFacets(a, b, bound);
      return;
    }
    struct Child {
      float bound;
      std::int32_t a, b;
    };
    Child children[64];
    int count = 0;
    // A bottom node stays while the other side descends.
    if (a.bottom()) {
      for (int j = 0; j < b.count; ++j) {
        const float least = *std::min_element(bound + 8 * j, bound + 8 * j + a.count);
        children[count++] = {least, index_a, b.child[j]};
      }
    } else if (b.bottom()) {
      for (int k = 0; k < a.count; ++k) {
        float least = bound[k];
        for (int j = 1; j < b.count; ++j) least = std::min(least, bound[8 * j + k]);
        children[count++] = {least, a.child[k], index_b};
      }
    } else {
      for (int j = 0; j < b.count; ++j) {
        for (int k = 0; k < a.count; ++k) {
          if (bound[8 * j + k] < best_) {
            children[count++] = {bound[8 * j + k], a.child[k], b.child[j]};
          }
        }
      }
    }
    std::sort(children, children + count,
              [](const Child& x, const Child& y) { return x.bound < y.bound; });
    for (int i = 0; i < count && children[i].bound < best_; ++i) {
      Visit(children[i].a, children[i].b);
    }
  }

  ClosestPair Result(double upper_bound) const {
    ClosestPair closest;
    if (found_.count == 0) return closest;
    const Witness w = WitnessOf(pair_, found_, 0);
    if (w.distance > upper_bound) return closest;
    const FeaturePair features = FeaturesOf(pair_, found_, 0);
    closest = {w.distance,
               w.p_ACa,
               w.p_ACb,
               w.normal_A,
               pair_.A.bvh().slot_facet[found_.slot_a[0]],
               pair_.B.bvh().slot_facet[found_.slot_b[0]],
               features.a,
               features.b};
    return closest;
  }

 private:
  static NodeExtents& Extents(int side) {
    return Scratch<std::array<NodeExtents, 2>>([] {})[side];
  }

  // Whether two nodes lie farther apart than the best distance along the line of the best pair.
  bool Apart(std::int32_t index_a, std::int32_t index_b) {
    if (found_.count == 0) return false;
    if (std::sqrt(best_) < stale_below_) Aim();
    const double apart = double{extents_a_.Least(index_a)} + extents_b_.Least(index_b) - offset_;
    return apart > 0 && apart * apart > best_ * length_;
  }

  // Takes the line of the best pair, from B towards A, for the direction of the extents. Extents
  // are no larger than the bodies, so single precision does; the way between them is in double.
  void Aim() {
    const Bvh &a = pair_.A.bvh(), &b = pair_.B.bvh();
    const double distance = std::sqrt(best_);
    stale_below_ = distance - kStaleAim * std::min({distance, a.size, b.size});
    const Vec3 line = Normalized({found_.normal[0][0], found_.normal[1][0], found_.normal[2][0]});
    const float n[3]{static_cast<float>(line.x), static_cast<float>(line.y),
                     static_cast<float>(line.z)};
    const Vec3 along{n[0], n[1], n[2]};  // what is rounded must be the same for all
    const Vec3 along_B = -(Transpose(pair_.X_AB.R) * along);
    const float n_B[3]{static_cast<float>(along_B.x), static_cast<float>(along_B.y),
                       static_cast<float>(along_B.z)};
    length_ = SquaredNorm(along) * (1 + kTouching);
    offset_ = Dot(along, pair_.X_AB * b.origin - a.origin) + kCullingSlack * (a.size + b.size) +
              kTouching * pair_.size;
    extents_a_.Start(a, n);
    extents_b_.Start(b, n_B);
  }

  void MeasureFacets(const BvhNode& a, const BvhNode& b, const float* bound) {
    std::uint64_t bits = 0;
    for (int j = 0; j < b.count; ++j) {
      for (int k = 0; k < a.count; ++k) {
        if (bound[8 * j + k] < best_) bits |= std::uint64_t{1} << (8 * j + k);
      }
    }
    if (bits == 0) return;
    bits = pair_.kernels.cull_by_axes(pair_.A.bvh().blocks[a.block], pair_.B.bvh().blocks[b.block],
                                      pair_.cull, static_cast<float>(std::sqrt(best_)), bits);
    chunk_.count = 0;
    for (; bits != 0; bits &= bits - 1) {
      const int bit = __builtin_ctzll(bits);
      chunk_.slot_a[chunk_.count] = a.child[bit & 7];
      chunk_.slot_b[chunk_.count++] = b.child[bit >> 3];
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

  // [m²] A bound whose square underflows must still admit a distance of zero.
  static constexpr double kTiny = 1e-300;
  const PosedPair& pair_;
  double best_;  // [m²]
  FacetPairs chunk_, found_;
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
  Search search(pair, upper_bound);
  search.Visit(0, 0);
  return search.Result(upper_bound);
}

}  // namespace contact_toolkit
