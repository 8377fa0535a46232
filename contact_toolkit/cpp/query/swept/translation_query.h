// Least distance over a pure translation. It carries a convex set over the hull of its two end
// positions, so one GJK for a pair of leaves is exact. But vectorised kernels are many times faster
// and leave little for it to do: most pairs of facets are separated over the whole way by a plane
// that is easily found, and as the distance of two convex sets is a convex function of the
// translation, measured at one time it bounds the rest from below by its tangent.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "query/swept/gjk.h"
#include "query/swept/swept.h"
#include "query/swept/swept_search.h"
#include "query/witness/facet_pair.h"
#include "shapes/node_extents.h"

namespace contact_toolkit {

class TranslationQuery {
 public:
  TranslationQuery(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                   double upper_bound);

  double squared_reach(const TimeSlice&) const {
    return best_.distance > 0 ? best_.distance * best_.distance : -1;
  }
  Vec3 direction() const { return direction_; }
  bool Apart(std::int32_t node_a, std::int32_t node_b);
  template <typename Bound>
  void Order(const BvhNode& a, const BvhNode& b, const SweptCull& cull, const Bound* bound,
             float* order) {
    if (meshes_) {
      OrderPosed(a, b, order);
    } else {
      OrderByMiddles(a, b, cull, bound, order);
    }
  }
  void Visit(const LeafPairs& pairs, const TimeSlice& whole);

  // Measures the pairs that were put off.
  void Finish();
  SweptDistance Answer() const;

 private:
  // Where B is when the closest pair so far is closest: so are its neighbours.
  const PosedPair& Posed();
  // By the distance of the boxes there and, as many overlap, of their middles.
  void OrderPosed(const BvhNode& a, const BvhNode& b, float* order);
  // Measures what seems the closest pair. The others are put off: most are culled by what is known
  // in the end.
  void VisitFacets(const LeafPairs& pairs);
  void MeasureLast();
  // [m] Pairs no closer than this could win by rounding only, and do not matter.
  double ToBeat() const;
  // Of the chunk of facet pairs, these keep those that may come closer than the closest so far:
  // by planes that separate the others over the whole way, what seems the closest last,
  void CullPrisms();
  // ... and by their distances and tangents at one time.
  void MeasurePosed();
  // Of facet pair i over the whole way, by the tangent there.
  double LowerBound(int i) const;
  void MeasureSwept(int slot_a, int slot_b);
  // Takes the line between the closest points so far for the direction of the nodes' extents.
  void Aim();

  const ConvexLeaves &A_, &B_;
  const Motion& motion_;
  const bool meshes_;
  std::vector<Vec3> swept_;
  Vec3 direction_;  // in which the last pair was separated
  Vec3 line_;       // of the closest points so far
  double lowest_;   // of the pairs that GJK gave up on
  SweptDistance best_;
  std::optional<PosedPair> start_, posed_;  // of meshes
  double posed_time_ = -1;
  const SweptKernels& kernels_ = ActiveSweptKernels();
  FacetPairs chunk_;
  std::array<double, FacetPairs::kCapacity> bound_;  // [m] from below, of the chunk's pairs
  struct {
    int count = 0;
    std::array<std::int32_t, FacetPairs::kCapacity> slot_a, slot_b;
    std::array<double, FacetPairs::kCapacity> bound;
  } put_off_;
  double stale_below_;  // [m] then the direction of the extents is to be taken anew
  double offset_ = 0;   // [m] of B's origin over the whole way, and slack
  double length_ = 1;   // of the direction as rounded
  NodeExtents &extents_a_, &extents_b_;
};

}  // namespace contact_toolkit
