// What a contact model remembers from one accepted step to the next; immutable, replaced whole.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "anchors.h"
#include "forces.h"

namespace contact_toolkit {

struct PairAnchors {
  int pair;
  std::shared_ptr<const AnchorSet> anchors;
};

struct StepTable : std::enable_shared_from_this<StepTable> {
  std::uint64_t id = 0;  // tells tables apart; 0 before the first step
  // Of the last accepted step; before the first, the time is −infinity and the rest empty.
  double time = -std::numeric_limits<double>::infinity();
  std::shared_ptr<const Forces> forces;
  std::vector<PairAnchors> anchors;  // of the pairs with anchored friction in contact, ascending
  // [J] Lost since the first step.
  double damping_loss = 0, friction_loss = 0;
};

}  // namespace contact_toolkit
