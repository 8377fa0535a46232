// What a contact model remembers from one accepted step to the next; immutable, replaced whole.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "contact/anchors.h"
#include "contact/easing.h"
#include "contact/forces.h"
#include "contact/surroundings.h"
#include "web/spring_web.h"

namespace contact_toolkit {

// Of a pair that was in contact at the last accepted step; of others both are null. Without
// friction there are no anchors.
struct PairState {
  int pair = -1;
  std::shared_ptr<const AnchorSet> anchors;
  std::shared_ptr<LatestMemory> memory = std::make_shared<LatestMemory>();
};

struct ContactState : std::enable_shared_from_this<ContactState> {
  std::uint64_t id = 0;        // tells states of a process apart; 0 before the first step
  std::uint64_t model_id = 0;  // of the ContactModel that took the step; 0 before the first step
  // Of the last accepted step; before the first, the time is −infinity and the rest empty.
  double time = -std::numeric_limits<double>::infinity();
  std::shared_ptr<const Forces> forces;
  std::vector<PairState> pairs;          // ascending
  std::vector<Separation> separations;   // likewise, of other pairs
  std::shared_ptr<const Easing> easing;  // null: every deformation is felt in full
  // [J] Lost since the first step.
  double damping_loss = 0, friction_loss = 0;
  double numerical_loss = 0;  // to implicit steps, which take more than the law does

  // What is kept of a pair; null pointers if nothing.
  PairState StateOf(int pair) const;
  // Its springs at the last accepted step; null if it had none.
  const PairSprings* SpringsOf(int pair) const;
  // How far apart it is; null if that is not known.
  const Separation* SeparationOf(int pair) const;

  // [m] What is not felt of a pair's deformation.
  double Withheld(int pair) const { return easing ? easing->Withheld(pair, time) : 0; }
};

// For a state that is not the one before the first step.
std::uint64_t NewStateId();

}  // namespace contact_toolkit
