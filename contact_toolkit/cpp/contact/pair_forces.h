// The forces of one pair's springs, from their deformations, stretches and relative velocity.
#pragma once

#include <span>

#include "contact/contact_law.h"
#include "contact/forces.h"
#include "contact/friction.h"
#include "math/relative_motion.h"
#include "web/spring_set.h"

namespace contact_toolkit {

// V_A: velocity of A relative to B as a field about Ao, in A. Fills one entry of `forces` a spring.
// `stretches` is read where the friction is anchored.
PairForce ComputePairForce(const ContactLaw& law, const Friction& friction,
                           const SpringSet& springs, const Twist& V_A,
                           std::span<const Stretch> stretches, std::span<SpringForce> forces);

}  // namespace contact_toolkit
