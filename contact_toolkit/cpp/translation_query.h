// Least distance over a pure translation. It carries a convex set over the hull of its two end
// positions, so one GJK for a pair of leaves is exact. But the distance of two convex sets is a
// convex function of the translation: measured at one time by the vectorised kernel, many times
// faster than GJK, it bounds the rest from below by its tangent, and few pairs of facets need more.
#pragma once

#include <memory>
#include <vector>

#include "facet_pair.h"
#include "gjk.h"
#include "swept.h"
#include "swept_search.h"

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
  void Visit(const LeafPairs& pairs, const TimeSlice& whole);

  SweptDistance Answer() const;

 private:
  // Measures facet pairs where B is when the closest pair so far is closest: so are its neighbours.
  void MeasurePosed(const LeafPairs& pairs);
  // Of facet pair i over the whole way, by the tangent there.
  double LowerBound(int i) const;
  void MeasureSwept(int slot_a, int slot_b);
  // Takes the line between the closest points so far for the direction of the nodes' extents.
  void Aim();

  const ConvexLeaves &A_, &B_;
  const Motion& motion_;
  const bool meshes_;
  std::vector<Vec3> swept_;
  Vec3 direction_;
  double lowest_;  // of the pairs that GJK gave up on
  SweptDistance best_;
  std::unique_ptr<const PosedPair> posed_;
  double posed_time_ = -1;
  FacetPairs chunk_;
  double aimed_at_;   // [m] best distance when last aimed
  float offset_ = 0;  // [m] of B's origin over the whole way, and slack
};

}  // namespace contact_toolkit
