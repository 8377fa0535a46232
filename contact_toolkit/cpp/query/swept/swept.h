// Distance, interference and time of impact of two shapes while B moves in A (see Motion).
#pragma once

#include <cstdint>
#include <limits>

#include "math/motion.h"
#include "shapes/convex_leaves.h"

namespace contact_toolkit {

struct SweptDistance {
  // The least distance over the motion lies between the two; equal in a pure translation.
  double lower_bound = std::numeric_limits<double>::infinity();
  double distance = std::numeric_limits<double>::infinity();  // infinity: none below upper_bound
  double time = 0;  // fraction of the motion at which the witness points are that far apart
  Vec3 p_ACa, p_ACb;
  std::int32_t facet_a = -1, facet_b = -1;  // facet or piece
  bool converged = true;                    // otherwise the two differ by more than the tolerance
};

// tolerance [m] is the most that lower_bound may stay below distance; translations need none.
SweptDistance FindSweptDistance(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                                double tolerance,
                                double upper_bound = std::numeric_limits<double>::infinity());

enum class ImpactStatus {
  kFree = 0,  // never as close as the separation
  kImpact = 1,
  kInitialContact = 2,  // as close already at the start
  kIterationLimit = 3,  // no closer than the separation before `time`; what follows is not known
};

struct TimeOfImpact {
  // Before `time` the shapes are further apart than the separation; at it, by no more than the
  // separation and the tolerance. 1 when free.
  double time = 1;
  double distance = std::numeric_limits<double>::infinity();  // at `time`; infinity when free
  Vec3 p_ACa, p_ACb, normal_A;  // unit, from B towards A; zero when overlapping
  std::int32_t facet_a = -1, facet_b = -1;
  ImpactStatus status = ImpactStatus::kFree;
};

TimeOfImpact FindTimeOfImpact(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                              double separation, double tolerance);

// Whether they touch during the motion; true also when they only come within the tolerance (within
// rounding in a pure translation).
bool SweptIntersects(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                     double tolerance);

}  // namespace contact_toolkit
