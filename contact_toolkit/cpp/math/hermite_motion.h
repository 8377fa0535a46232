// Where a body was halfway through a step, from its poses and velocities at the ends: a cubic
// through all four, for positions and, in the tangent space of the first pose, for rotations.
// Errors of the fourth power of the step. And where it would be, had nothing changed its velocity.
#pragma once

#include "math/relative_motion.h"
#include "math/vec.h"

namespace contact_toolkit {

struct BodyState {
  Pose X_FB;
  Twist V_FB;
};

BodyState Halfway(const BodyState& start, const BodyState& end, double duration);
Pose Coasted(const BodyState& start, double duration);

}  // namespace contact_toolkit
