// What a contact model remembers from one accepted step to the next; immutable, replaced whole.
#pragma once

#include <limits>
#include <memory>

#include "forces.h"

namespace contact_toolkit {

struct StepTable {
  // Of the last accepted step; before the first, the time is −infinity and the rest empty.
  double time = -std::numeric_limits<double>::infinity();
  std::shared_ptr<const Forces> forces;
  // [J] Lost since the first step.
  double damping_loss = 0, friction_loss = 0;
};

}  // namespace contact_toolkit
