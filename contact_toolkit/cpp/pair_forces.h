// The forces of one pair's springs, from their deformations and the relative velocity.
#pragma once

#include "contact_law.h"
#include "forces.h"
#include "relative_motion.h"
#include "spring_set.h"

namespace contact_toolkit {

// Of B on A: about Ao, in A. What A does to B is the same with the opposite sign.
struct PairForce {
  Vec3 torque, force;
  Energetics energetics;
};

// V_A: velocity of A relative to B as a field about Ao, in A. Fills one entry of `springs` for each
// row.
PairForce ComputePairForce(const ContactLaw& law, const SpringSet& set, const Twist& V_A,
                           SpringForce* springs);

}  // namespace contact_toolkit
