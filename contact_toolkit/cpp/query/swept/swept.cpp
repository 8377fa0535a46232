#include "query/swept/swept.h"

#include <algorithm>

#include "base/tolerances.h"
#include "query/swept/impact_query.h"
#include "query/swept/rotation_query.h"
#include "query/swept/swept_search.h"
#include "query/swept/translation_query.h"
#include "query/witness/witness.h"

namespace contact_toolkit {
namespace {

// [m] What rounding alone can do to a distance between the two shapes.
double RoundingOf(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion) {
  const Vec3 start = motion.At(0).p, end = motion.At(1).p;
  return kTouching * (A.bvh().size + Norm(A.bvh().origin) + B.bvh().size + Norm(B.bvh().origin) +
                      std::max(Norm(start), Norm(end)));
}

TimeOfImpact FindImpact(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                        double separation, double tolerance, bool any_time) {
  ImpactQuery query(A, B, motion, separation, std::max(tolerance, RoundingOf(A, B, motion)),
                    any_time);
  do {
    SweptSearch(A, B, motion, query.end(), &query).Run();
  } while (query.Restart());
  return query.answer();
}

}  // namespace

SweptDistance FindSweptDistance(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                                double tolerance, double upper_bound) {
  if (motion.still() && A.mesh() != nullptr && B.mesh() != nullptr) {
    const ClosestPair pair = FindDistance(*A.mesh(), *B.mesh(), motion.At(0), upper_bound);
    return {pair.distance, pair.distance, 0,   pair.p_ACa, pair.p_ACb,
            pair.facet_a,  pair.facet_b,  true};
  }
  if (!motion.rotates()) {
    TranslationQuery query(A, B, motion, upper_bound);
    query.Run();
    return query.Answer();
  }
  RotationQuery query(A, B, motion, std::max(tolerance, RoundingOf(A, B, motion)), upper_bound);
  if (A.mesh() != nullptr && B.mesh() != nullptr) {
    for (const double s : {0.5, 0.0, 1.0}) {
      query.Start(s, FindDistance(*A.mesh(), *B.mesh(), motion.At(s), query.distance()));
    }
  }
  SweptSearch(A, B, motion, 1, &query).Run();
  return query.Answer();
}

TimeOfImpact FindTimeOfImpact(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                              double separation, double tolerance) {
  return FindImpact(A, B, motion, separation, tolerance, false);
}

bool SweptIntersects(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                     double tolerance) {
  if (motion.still() && A.mesh() != nullptr && B.mesh() != nullptr) {
    return Intersects(*A.mesh(), *B.mesh(), motion.At(0));
  }
  if (!motion.rotates()) {
    const double rounding = RoundingOf(A, B, motion);
    return FindSweptDistance(A, B, motion, tolerance, rounding).distance <= rounding;
  }
  return FindImpact(A, B, motion, 0, tolerance, true).status != ImpactStatus::kFree;
}

}  // namespace contact_toolkit
