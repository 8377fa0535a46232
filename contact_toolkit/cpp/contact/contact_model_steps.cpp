// The contact model from one accepted step to the next: what is lost on the way, and what the next
// step knows.
#include <atomic>
#include <stdexcept>
#include <utility>

#include "base/parallel.h"
#include "base/same_bits.h"
#include "base/tolerances.h"
#include "contact/anchor_update.h"
#include "contact/contact_model.h"
#include "math/hermite_motion.h"

namespace contact_toolkit {

Energetics ContactModel::Lost(const ContactState& state, const Forces& end, double duration) const {
  const Forces& start = *state.forces;
  Energetics sum = start.energetics;
  sum += end.energetics;
  const double lost = 0.5 * duration * (sum.damping_power + std::abs(sum.tangential_power));
  const double energy =
      sum.stored_normal + sum.stored_tangential + state.damping_loss + state.friction_loss;
  if (lost <= kLedgerTolerance * energy) {
    sum *= 0.5 * duration;
    return sum;
  }
  std::vector<Pose> X_FB(num_bodies_);
  std::vector<Twist> V_FB(num_bodies_);
  for (int i = 0; i < num_bodies_; ++i) {
    const BodyState halfway = Halfway({start.loaded->X_FB[i], start.V_FB[i]},
                                      {end.loaded->X_FB[i], end.V_FB[i]}, duration);
    X_FB[i] = halfway.X_FB;
    V_FB[i] = halfway.V_FB;
  }
  Energetics halfway = ComputeForces(Find(X_FB, &state), V_FB, &state)->energetics;
  halfway *= 4;
  sum += halfway;
  sum *= duration / 6;
  return sum;
}

std::shared_ptr<const Forces> ContactModel::Coast(const ContactState& state,
                                                  double duration) const {
  if (!state.forces) return nullptr;
  const Forces& start = *state.forces;
  std::vector<Pose> X_FB(num_bodies_);
  for (int i = 0; i < num_bodies_; ++i) {
    X_FB[i] = Coasted({start.loaded->X_FB[i], start.V_FB[i]}, duration);
  }
  return ComputeForces(Find(X_FB, &state), start.V_FB, &state);
}

std::shared_ptr<const ContactState> ContactModel::Eased(Easing easing) const {
  if (easing.depth.size() != pairs_.size()) {
    throw std::invalid_argument("depths must be one for each pair");
  }
  if (!(easing.duration > 0)) throw std::invalid_argument("duration must be positive");
  for (const double depth : easing.depth) {
    if (!(depth >= 0)) throw std::invalid_argument("depths must not be negative");
  }
  const auto state = std::make_shared<ContactState>();
  state->id = NewStateId();
  state->model_id = id_;
  state->easing = std::make_shared<const Easing>(std::move(easing));
  return state;
}

std::shared_ptr<const ContactState> ContactModel::Advance(
    std::shared_ptr<const ContactState> state, double time,
    std::shared_ptr<const Forces> forces) const {
  const Forces* last = state->forces.get();
  if (last && time == state->time && SameBits<Pose>(last->loaded->X_FB, forces->loaded->X_FB) &&
      SameBits<Twist>(last->V_FB, forces->V_FB)) {
    return state;
  }
  if (time < state->time) {
    const auto afresh = std::make_shared<ContactState>();
    afresh->easing = state->easing;
    state = afresh;
    last = nullptr;
  }
  if (forces->state_id != state->id) {
    forces = EvaluateForces(forces->loaded, forces->V_FB, state.get());
  }
  bool dragged = false;
  const auto next = Next(*state, time, forces, &dragged);
  if (last) {
    const Energetics lost = Lost(*state, *forces, time - state->time);
    next->damping_loss += lost.damping_power;
    next->friction_loss += lost.tangential_power - (forces->energetics.stored_tangential -
                                                    last->energetics.stored_tangential);
  }
  // What was dragged pulls differently from here on, and the next step starts with that.
  if (dragged) next->forces = EvaluateForces(forces->loaded, forces->V_FB, next.get());
  return next;
}

std::shared_ptr<const ContactState> ContactModel::AdvanceImplicitly(
    std::shared_ptr<const ContactState> state, double time,
    std::shared_ptr<const Forces> forces) const {
  if (forces->state_id != state->id) {
    forces = EvaluateForces(forces->loaded, forces->V_FB, state.get());
  }
  bool dragged = false;
  const auto next = Next(*state, time, forces, &dragged);
  if (const Forces* last = state->forces.get()) {
    const Energetics &start = last->energetics, &end = forces->energetics;
    const double duration = time - state->time;
    const double damped = duration * end.damping_power, rubbed = duration * end.tangential_power;
    next->damping_loss += damped;
    next->friction_loss += rubbed - (end.stored_tangential - start.stored_tangential);
    // A constant force changes the kinetic energy by its power at the mean of the velocities.
    const double given = 0.5 * (forces->PowerAt(last->V_FB) + forces->PowerAt(forces->V_FB));
    next->numerical_loss +=
        -duration * given - (end.stored_normal - start.stored_normal) - damped - rubbed;
  }
  return next;
}

std::shared_ptr<ContactState> ContactModel::Next(const ContactState& state, double time,
                                                 std::shared_ptr<const Forces> forces,
                                                 bool* dragged) const {
  const Forces* last = state.forces.get();
  const auto next = std::make_shared<ContactState>();
  next->id = NewStateId();
  next->model_id = id_;
  next->time = time;
  next->easing = state.easing;
  next->damping_loss = state.damping_loss;
  next->friction_loss = state.friction_loss;
  next->numerical_loss = state.numerical_loss;
  next->pairs.resize(forces->loaded->size);
  std::atomic<bool> changed = false;
  ParallelFor(static_cast<int>(forces->loaded->size), threads_, [&](int i, int) {
    const PairSprings& entry = forces->loaded->pairs[i];
    const ContactPair& pair = pairs_[entry.pair];
    PairState pair_state = state.StateOf(entry.pair);
    if (pair.friction.anchored()) {
      const auto before = pair_state.anchors;
      pair_state.anchors = UpdateAnchors(pair.friction, entry.springs, entry.X_AB,
                                         forces->StretchesOf(i), forces->SpringsOf(i), before);
      if (pair_state.anchors != before) changed.store(true, std::memory_order_relaxed);
    }
    const Pose last_X_AB = last ? PoseOf(pair, last->loaded->X_FB) : entry.X_AB;
    auto memory = entry.known.memory;
    if (!memory && pair_state.memory) memory = pair_state.memory->Get();
    pair_state.memory = std::make_shared<LatestMemory>();
    pair_state.memory->Set(pair.web->Remember(entry.springs, last_X_AB, entry.X_AB, memory));
    next->pairs[i] = std::move(pair_state);
  });
  next->separations = Separations(state, *forces->loaded);
  next->forces = std::move(forces);
  *dragged = changed;
  return next;
}

Separation ContactModel::SeparationOf(int index, const Pose& last_X_AB, const Pose& X_AB,
                                      const ContactState& state) const {
  if (state.Withheld(index) > 0) return {};  // it may overlap
  const ContactPair& pair = pairs_[index];
  const double moved = Moved(pair, last_X_AB, X_AB);
  const Separation* before = state.SeparationOf(index);
  if (before && Moved(pair, before->X_AB, X_AB) + moved <= before->clearance) return *before;
  const double bound = pair.web->Clearance(X_AB, moved);
  return bound > moved ? Separation{index, X_AB, bound} : Separation{};
}

std::vector<Separation> ContactModel::Separations(const ContactState& state,
                                                  const LoadedSprings& loaded) const {
  std::vector<Separation> all(loaded.idle.size());
  const Forces* last = state.forces.get();
  ParallelFor(static_cast<int>(all.size()), threads_, [&](int i, int) {
    const ContactPair& pair = pairs_[loaded.idle[i]];
    const Pose X_AB = PoseOf(pair, loaded.X_FB);
    const Pose last_X_AB = last ? PoseOf(pair, last->loaded->X_FB) : X_AB;
    all[i] = SeparationOf(loaded.idle[i], last_X_AB, X_AB, state);
  });
  std::erase_if(all, [](const Separation& apart) { return !(apart.clearance > 0); });
  return all;
}

}  // namespace contact_toolkit
