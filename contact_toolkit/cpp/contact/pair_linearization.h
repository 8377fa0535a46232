// How the force of a pair changes with its pose and velocity: what a solver needs that takes
// contact and motion together.
#pragma once

#include <span>

#include "contact/pair_forces.h"
#include "contact/stretch.h"
#include "math/mat6.h"

namespace contact_toolkit {

// First-order change of the wrench on geometry A about Ao when A is displaced relative to B by
// xi = (rotation [rad], translation of Ao [m]) and its relative twist changes by dV = (angular,
// velocity of Ao), B held, everything in A's axes before the displacement:
//   dW = −(stiffness · xi + damping · dV),  W = (torque about the displaced Ao, force).
// The twist is held in those axes while A is displaced, and the anchors of friction are.
struct PairLinearization {
  Mat6 stiffness, damping;
};

enum class Symmetry {
  kNone,  // the derivative of the force, which sliding friction and damping make unsymmetric
  kKept,  // without the change of sliding friction with the normal force; of the rest, the
          // symmetric part
};

// ComputePairForce() and the derivative of what it computes. The springs must have been asked for
// their slopes. Anchored friction needs `sources`, from FindStretches(): without them springs count
// as anchored where they are.
PairForce LinearizePair(const ContactLaw& law, const Friction& friction, const SpringSet& springs,
                        const Twist& V_A, std::span<const Stretch> stretches,
                        std::span<SpringForce> forces, PairLinearization* out,
                        const StretchSources* sources = nullptr,
                        Symmetry symmetry = Symmetry::kNone);

}  // namespace contact_toolkit
