#include "contact/pair_forces.h"

#include <algorithm>
#include <cmath>

namespace contact_toolkit {
namespace {

// One tangential spring and damper within its cone. `load`: the normal force; `slip`: the
// tangential velocity.
void ComputeFriction(const Friction& friction, double stiffness, double elastic, double load,
                     const Vec3& slip, const Stretch& stretch, SpringForce* force,
                     Energetics* energetics) {
  const Vec3& stretch_A = stretch.stretch_A;
  const double along = Dot(slip, stretch_A);
  const double squared_length = SquaredNorm(stretch_A);
  force->moving_on = squared_length > 0 ? along > 0 : SquaredNorm(slip) > 0;
  force->anchored = friction.anchored() && !stretch.sliding;

  const double limit = friction.Limit(load, stretch.sliding);
  const double tangential_stiffness = friction.TangentialStiffness(stiffness);
  const Vec3 trial =
      -tangential_stiffness * stretch_A - friction.TangentialDamping(stiffness, elastic) * slip;
  const double squared_size = SquaredNorm(trial);
  const double kept = squared_size > limit * limit ? limit / std::sqrt(squared_size) : 1.0;
  force->friction_A = kept * trial;

  const double power = -Dot(force->friction_A, slip);
  energetics->tangential_power += power;
  const double squared_pull = tangential_stiffness * tangential_stiffness * squared_length;
  if (squared_pull > limit * limit) {
    // Stretch beyond the cone has been slipped, not stored.
    energetics->friction_power += power;
    energetics->stored_tangential += 0.5 * limit * limit / tangential_stiffness;
  } else {
    energetics->friction_power += power - tangential_stiffness * along;
    energetics->stored_tangential += 0.5 * tangential_stiffness * squared_length;
  }
}

}  // namespace

PairForce ComputePairForce(const ContactLaw& law, const Friction& friction,
                           const SpringSet& springs, const Twist& V_A,
                           std::span<const Stretch> stretches, std::span<SpringForce> forces) {
  constexpr Stretch kNew{};
  PairForce total;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const Vec3& p_AC = springs.p_AC[i];
    const Vec3& normal_A = springs.normal_A[i];
    const double steepness = springs.steepness[i], elastic = springs.elastic[i];
    const Vec3 velocity = VelocityAt(V_A, p_AC);
    const double approach = -Dot(normal_A, velocity);
    SpringForce& spring = forces[i];
    spring.rate = steepness * approach;
    spring.normal = law.NormalForce(elastic, spring.rate);
    total.energetics.stored_normal += springs.energy[i];
    total.energetics.damping_power += (spring.normal - elastic) * spring.rate;
    const double load = steepness * spring.normal;
    if (friction.active() && steepness > 0 && springs.stiffness[i] > 0) {
      ComputeFriction(friction, springs.stiffness[i], elastic, load, velocity + approach * normal_A,
                      friction.anchored() ? stretches[i] : kNew, &spring, &total.energetics);
    } else {
      spring.friction_A = {};
      spring.anchored = spring.moving_on = false;
    }
    const Vec3 force = load * normal_A + spring.friction_A;
    total.force += force;
    total.torque += Cross(p_AC, force);
  }
  return total;
}

}  // namespace contact_toolkit
