// How the wrenches of a pair change as its bodies move: those of the springs, and those of what
// turns along, arms, axes and the velocities at the point.
#pragma once

#include "contact/pair_linearization.h"
#include "math/mat6.h"
#include "step/body_kinematics.h"

namespace contact_toolkit {

// Everything in F. P is the origin of geometry A, fixed to A's body.
class PairDerivative {
 public:
  struct Body {
    Vec3 arm;  // of P from the origin that moves with the body
    Twist V;   // of the body, its velocity that at P
  };

  // `linear`: the springs' in A's axes, which R turns into F; `wrench`: on A about P.
  PairDerivative(const PairLinearization& linear, const Mat3& R, const Slope& wrench, const Body& a,
                 const Body& b, Symmetry symmetry);

  // On the two bodies about their origins. With Symmetry::kKept that of the springs alone.
  struct Wrenches {
    Slope on_a, on_b;
  };
  Wrenches ByA(const BodyKinematics::Change& change) const;
  Wrenches ByB(const BodyKinematics::Change& change) const;

 private:
  // From a change of the wrench about P, and changes of the arms.
  Wrenches About(const Slope& change, const Vec3& arm_a, const Vec3& arm_b) const;

  Mat6 stiffness_, damping_;
  Slope wrench_;
  Body a_, b_;
  bool whole_;
};

}  // namespace contact_toolkit
