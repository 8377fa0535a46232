// Where floating bodies go in a step without contact.
#pragma once

#include <span>
#include <vector>

#include "step/step_problem.h"

namespace contact_toolkit {

// Velocities at the end of a step under gravity alone, with the inertia and gyroscopic forces of
// its start; of floating trees, others keep theirs.
std::vector<double> FreeMotion(const StepTopology& topology, std::span<const double> q0,
                               std::span<const double> v0, double step, const Vec3& gravity);

}  // namespace contact_toolkit
