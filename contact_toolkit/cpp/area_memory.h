// What an area web remembers between steps: the nodes that may bear load near a pose, how far each
// is from doing so, and for the exact field the facets closest to it.
#pragma once

#include "area_candidates.h"
#include "motion_bound.h"
#include "near_facets.h"
#include "sphere_tree.h"
#include "spring_web.h"
#include "vec.h"

namespace contact_toolkit {

struct AreaMemory final : WebMemory {
  Pose X_PS;         // of the sampled body in the probed one, when it was gathered
  Sphere around;     // of which motions are measured, in the sampled body
  double slack = 0;  // [m] of motion that it serves
  AreaCandidates candidates;
  NearFacets facets;  // of each candidate; none with the smooth field

  double Motion(const Pose& now) const { return MotionAround(around, X_PS, now); }

  // [m] No point of the ball moves farther within the slack.
  double Way(const Vec3& p, double radius) const;

  // Drops triangles without a corner that may be loaded within the slack, and nodes of none; then
  // enlarges the sphere to hold them all.
  void Prune();
};

}  // namespace contact_toolkit
