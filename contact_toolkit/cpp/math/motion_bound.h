// A bound on how far the points of a body move from one pose to another. What was computed at the
// first pose (nearby features, distances) stays valid at the second within that bound.
#pragma once

#include <cmath>

#include "base/tolerances.h"
#include "math/sphere_tree.h"
#include "math/vec.h"

namespace contact_toolkit {

// [m] An upper bound: no point within the sphere moves further, and those beyond it in proportion
// to their distance from its centre.
inline double MotionAround(const Sphere& around, const Pose& before, const Pose& after) {
  // |ΔR p + Δp|, with the Frobenius norm of ΔR for its spectral norm.
  Mat3 change;
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    change.row[i] = after.R.row[i] - before.R.row[i];
    squared += SquaredNorm(change.row[i]);
  }
  const double moved = Norm(change * around.center + (after.p - before.p));
  const double rounding = kTouching * (Norm(around.center) + around.radius + Norm(after.p));
  return moved + std::sqrt(squared) * around.radius + rounding;
}

}  // namespace contact_toolkit
