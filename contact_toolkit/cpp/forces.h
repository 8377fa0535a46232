// What the springs of a whole model do at one configuration and velocity; immutable once made.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "found.h"
#include "relative_motion.h"
#include "vec.h"

namespace contact_toolkit {

// Sums over springs [J] and [W].
struct Energetics {
  double stored_normal = 0, stored_tangential = 0;
  double damping_power = 0, friction_power = 0;  // lost, ≥ 0

  Energetics& operator+=(const Energetics& other) {
    stored_normal += other.stored_normal, stored_tangential += other.stored_tangential;
    damping_power += other.damping_power, friction_power += other.friction_power;
    return *this;
  }
};

// One spring's share, in the order of Found.
struct SpringForce {
  double rate = 0;        // [m/s] of deformation
  double normal = 0;      // [N] along gradient_A
  Vec3 friction_A;        // [N] on A, in A
  bool anchored = false;  // held by an anchor rather than sliding
};

// Torque about a body's origin, and force.
struct Wrench {
  Vec3 torque, force;
};
static_assert(sizeof(Wrench) == 6 * sizeof(double));

struct Forces {
  std::shared_ptr<const Found> found;
  std::vector<Twist> V_FB;            // the body velocities, in F
  std::vector<Wrench> body_wrenches;  // about Bo, in F
  std::vector<SpringForce> springs;
  std::vector<std::size_t> first;  // index into `springs` of each loaded pair's first
  Energetics energetics;

  void Retire() { found.reset(); }
};

}  // namespace contact_toolkit
