// Where the bodies of a contact model are at the end of a step, as a function of its velocities.
#pragma once

#include <span>
#include <vector>

#include "step/step_problem.h"

namespace contact_toolkit {

class BodyKinematics {
 public:
  BodyKinematics(const StepTopology& topology, const StepProblem& problem);

  // Pose and velocity at the end of a step at velocities v (nv).
  Pose PoseOf(int body, std::span<const double> v) const;
  Twist TwistOf(int body, std::span<const double> v) const;

  // What moves with a body, and where: the root of a floating tree, about whose origin the tree's
  // velocities are taken, else the body itself. Its origin, from the body's pose.
  Vec3 OriginOf(int body, const Pose& X_FB) const;

  // How pose and velocity of that change, at the end of a step at v, with each velocity of the tree
  // that moves it.
  struct Change {
    int dof = 0;       // of the tree
    Vec3 turn, way;    // displacement
    Vec3 spin, speed;  // angular velocity, velocity of the origin
  };
  void Differentiate(int body, std::span<const double> v, std::vector<Change>* changes) const;

 private:
  Pose EndOfRoot(const StepTree& tree, std::span<const double> v) const;

  const StepTopology& topology_;
  const StepProblem& problem_;
};

// Of a quaternion [w x y z], of any length.
Mat3 RotationOf(const double* q);

// The rotation that a unit quaternion undergoes when its rate at angular velocity w is held for
// `step` and the result normalized: by 2 atan(step |w| / 2).
Mat3 QuaternionStep(const Vec3& w, double step);

}  // namespace contact_toolkit
