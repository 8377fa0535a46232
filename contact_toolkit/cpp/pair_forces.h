// The forces of one pair's springs, from their deformations, stretches and relative velocity.
#pragma once

#include <span>

#include "contact_law.h"
#include "forces.h"
#include "friction.h"
#include "relative_motion.h"
#include "spring_set.h"

namespace contact_toolkit {

// Of B on A: about Ao, in A. What A does to B is the same with the opposite sign.
struct PairForce {
  Vec3 torque, force;
  Energetics energetics;
};

// V_A: velocity of A relative to B as a field about Ao, in A. Fills one entry of `forces` a spring.
// `stretches` is read where the friction is anchored.
PairForce ComputePairForce(const ContactLaw& law, const Friction& friction,
                           const SpringSet& springs, const Twist& V_A,
                           std::span<const Stretch> stretches, std::span<SpringForce> forces);

}  // namespace contact_toolkit
