// What a contact model remembers from one accepted step to the next; immutable, replaced whole.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "anchors.h"
#include "forces.h"
#include "spring_web.h"

namespace contact_toolkit {

// Of a pair that was in contact at the last accepted step; either may be null.
struct PairState {
  int pair;
  std::shared_ptr<const AnchorSet> anchors;
  std::shared_ptr<const WebMemory> memory;
};

struct StepTable : std::enable_shared_from_this<StepTable> {
  std::uint64_t id = 0;  // tells tables apart; 0 before the first step
  // Of the last accepted step; before the first, the time is −infinity and the rest empty.
  double time = -std::numeric_limits<double>::infinity();
  std::shared_ptr<const Forces> forces;
  std::vector<PairState> pairs;  // ascending
  // [J] Lost since the first step.
  double damping_loss = 0, friction_loss = 0;

  // What is kept of a pair; null pointers if nothing.
  PairState StateOf(int pair) const;
};

}  // namespace contact_toolkit
