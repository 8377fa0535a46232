// What an area web remembers between steps: the nodes that may bear load near a pose, how far each
// is from doing so, and for the exact field the facets closest to it.
#pragma once

#include "math/motion_bound.h"
#include "math/sphere_tree.h"
#include "math/vec.h"
#include "query/point/near_facets.h"
#include "web/area/area_candidates.h"
#include "web/spring_web.h"

namespace contact_toolkit {

struct AreaMemory final : WebMemory {
  Pose X_PS;         // of the sampled body in the probed one, when it was gathered
  Sphere around;     // of which motions are measured, in the sampled body
  double slack = 0;  // [m] of motion that it serves
  AreaCandidates candidates;
  NearFacets facets;  // of each candidate; none with the smooth field, and of a primitive

  double Motion(const Pose& now) const { return MotionAround(around, X_PS, now); }

  // [m] No point of the ball moves farther within the slack.
  double Way(const Vec3& p, double radius) const;

  // Drops triangles that are not loaded within the slack, and nodes of none; then enlarges the
  // sphere to hold them all. `edges`: whether edges may poke through a triangle between its nodes.
  void Prune(bool edges);

 private:
  void KeepTriangles(std::int32_t first, std::int32_t last, bool edges, AreaCandidates* kept) const;
};

}  // namespace contact_toolkit
