// Least distance over a pure translation. It carries a convex set over the hull of its two end
// positions, so one GJK for a pair of leaves is exact. But vectorised kernels are many times faster
// and leave little for it to do: most pairs of facets are separated over the whole way by a plane
// that is easily found, and as the distance of two convex sets is a convex function of the
// translation, measured at one time it bounds the rest from below by its tangent. The search is
// that of the static distance, with the boxes and slabs that B's sweep over, in the order in which
// they lie where the closest pair so far is closest: its neighbours are so too.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "kernels/swept_kernels.h"
#include "math/motion.h"
#include "query/swept/gjk.h"
#include "query/swept/swept.h"
#include "query/witness/facet_pair.h"
#include "query/witness/line_cull.h"
#include "shapes/convex_leaves.h"

namespace contact_toolkit {

class TranslationQuery {
 public:
  TranslationQuery(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                   double upper_bound);

  void Run();
  SweptDistance Answer() const;

  // What NearestSearch asks for.
  double squared_reach() const { return best_.distance * best_.distance; }
  bool Done() const { return !(best_.distance > 0); }
  bool Apart(std::int32_t node_a, std::int32_t node_b) {
    return best_.facet_a >= 0 && line_cull_.Apart(node_a, node_b, best_.distance, line_);
  }
  std::uint64_t Bounds(const BvhNode& a, const BvhNode& b, float* bound) const {
    return kernels_.translation_bounds(a, b, cull_, Limit(), bound);
  }
  std::uint64_t Orders(const BvhNode& a, const BvhNode& b, float* bound, float* order);
  std::uint64_t Cull(const BvhNode& a, const BvhNode& b, std::uint64_t pairs) const;
  void Measure(const BvhNode& a, const BvhNode& b, std::uint64_t pairs);

 private:
  float Limit() const { return static_cast<float>(std::min(squared_reach(), 1e38)); }
  // Where B is when the closest pair so far is closest.
  const PosedPair& Posed();
  // Measures what seems the closest pair. The others are put off: most are culled by what is known
  // in the end.
  void MeasureFacets();
  void MeasureLast();
  // Of the chunk, what has the least bound.
  void PutLeastLast();
  // Measures the pairs that were put off.
  void Finish();
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

  const ConvexLeaves &A_, &B_;
  const Motion& motion_;
  const bool meshes_;
  const SweptCull cull_;  // over the whole way
  LineCull line_cull_;
  std::vector<Vec3> swept_;
  Vec3 direction_;  // in which the last pair was separated
  Vec3 line_;       // of the closest points so far
  double lowest_;   // of the pairs that GJK gave up on
  SweptDistance best_;
  float at_[3];                             // [m] of B's boxes in A's at ...
  double at_time_ = -1;                     // ... the time of the closest pair when last asked for
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
};

}  // namespace contact_toolkit
