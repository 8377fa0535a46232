// Least distance and interference by branch and bound.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/tolerances.h"
#include "query/witness/facet_pair.h"
#include "query/witness/line_cull.h"
#include "query/witness/nearest_search.h"
#include "query/witness/witness.h"

namespace contact_toolkit {
namespace {

class DistanceQuery {
 public:
  // Looks for pairs up to upper_bound [m], until one is no farther apart than `enough` [m].
  DistanceQuery(const PosedPair& pair, double upper_bound, double enough)
      : pair_(pair),
        A_(pair.A.bvh()),
        B_(pair.B.bvh()),
        enough_(enough * enough),
        best_(std::max(upper_bound * upper_bound * (1 + 1e-9), upper_bound > 0 ? kTiny : 0)),
        line_(A_, B_, pair.X_AB.R, pair.X_AB * B_.origin - A_.origin,
              pair.X_AB * B_.origin - A_.origin, kTouching * pair.size) {}

  void Run() { NearestSearch(A_, B_, this).Run(); }

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

  // What NearestSearch asks for.
  double squared_reach() const { return best_; }
  bool Done() const { return found() && best_ <= enough_; }

  bool Apart(std::int32_t node_a, std::int32_t node_b) {
    return found() && line_.Apart(node_a, node_b, std::sqrt(best_), At(found_.normal, 0));
  }

  std::uint64_t Bounds(const BvhNode& a, const BvhNode& b, float* bound) const {
    return pair_.kernels.box_bounds(a, b, pair_.cull, Limit(), bound);
  }

  std::uint64_t Orders(const BvhNode& a, const BvhNode& b, float* bound, float* order) const {
    return pair_.kernels.box_orders(a, b, pair_.cull, Limit(), kMiddles, bound, order);
  }

  std::uint64_t Cull(const BvhNode& a, const BvhNode& b, std::uint64_t bits) const {
    return pair_.kernels.cull_by_axes(A_.blocks[a.block], B_.blocks[b.block], pair_.cull,
                                      static_cast<float>(std::sqrt(best_)), bits);
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

 private:
  float Limit() const { return static_cast<float>(std::min(best_, 1e38)); }

  // [m²] A bound whose square underflows must still admit a distance of zero.
  static constexpr double kTiny = 1e-300;
  const PosedPair& pair_;
  const Bvh &A_, &B_;
  const double enough_;  // [m²]
  double best_;          // [m²]
  FacetPairs chunk_, found_;
  LineCull line_;
};

}  // namespace

ClosestPair FindDistance(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                         double upper_bound) {
  const PosedPair pair(A, B, X_AB);
  DistanceQuery query(pair, upper_bound, 0);
  query.Run();
  return query.Result(upper_bound);
}

double LeastDistance(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                     double enough) {
  const PosedPair pair(A, B, X_AB);
  DistanceQuery query(pair, std::numeric_limits<double>::infinity(), std::max(enough, 0.0));
  query.Run();
  const double distance = query.Result(std::numeric_limits<double>::infinity()).distance;
  return distance - kCertain * (A.diagonal() + B.diagonal() + distance);
}

bool Intersects(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB) {
  const PosedPair pair(A, B, X_AB);
  const double touching = kTouching * pair.size;
  DistanceQuery query(pair, touching, touching);
  query.Run();
  return query.found();
}

}  // namespace contact_toolkit
