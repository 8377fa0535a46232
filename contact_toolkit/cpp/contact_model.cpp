#include "contact_model.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <utility>

#include "anchor_update.h"
#include "broad_phase.h"
#include "hermite_motion.h"
#include "parallel.h"
#include "tolerances.h"

namespace contact_toolkit {
namespace {

template <typename T>
bool SameBits(std::span<const T> a, std::span<const T> b) {
  static_assert(sizeof(T) % sizeof(double) == 0);
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

std::uint64_t NextTableId() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

ContactModel::ContactModel(int num_bodies, std::vector<ContactGeometry> geometries,
                           std::vector<ContactPair> pairs, int threads)
    : num_bodies_(num_bodies),
      geometries_(std::move(geometries)),
      pairs_(std::move(pairs)),
      threads_(threads) {}

Pose ContactModel::PoseOf(const ContactPair& pair, std::span<const Pose> X_FB) const {
  const ContactGeometry &a = geometries_[pair.a], &b = geometries_[pair.b];
  return RelativePose(a.X_BG, RelativePose(X_FB[a.body], X_FB[b.body]) * b.X_BG);
}

Twist ContactModel::MotionOf(const ContactPair& pair, std::span<const Pose> X_FB,
                             std::span<const Twist> V_FB) const {
  const ContactGeometry &a = geometries_[pair.a], &b = geometries_[pair.b];
  const Pose& X_FA = X_FB[a.body];
  const Twist V_F = RelativeTwist(X_FA, V_FB[a.body], X_FB[b.body], V_FB[b.body]);
  const Mat3 R_GF = Transpose(X_FA.R * a.X_BG.R);
  return {R_GF * V_F.w, R_GF * VelocityAt(V_F, X_FA.R * a.X_BG.p)};
}

std::shared_ptr<const Found> ContactModel::Find(std::span<const Pose> X_FB,
                                                const StepTable* table) const {
  if (table && table->forces && SameBits<Pose>(table->forces->found->X_FB, X_FB)) {
    return table->forces->found;
  }
  const std::shared_ptr<Found> found = found_stock_.Take();
  found->X_FB.assign(X_FB.begin(), X_FB.end());
  const std::vector<int> near = PairsInReach(geometries_, pairs_, X_FB);
  if (found->loaded.size() < near.size()) found->loaded.resize(near.size());
  ParallelFor(static_cast<int>(near.size()), threads_, [&](int i, int) {
    const ContactPair& pair = pairs_[near[i]];
    const ContactGeometry& a = geometries_[pair.a];
    PairSprings& entry = found->loaded[i];
    entry.pair = near[i];
    entry.X_FA = X_FB[a.body] * a.X_BG;
    entry.X_AB = PoseOf(pair, X_FB);
    const auto memory = table ? table->StateOf(near[i]).memory : nullptr;
    if (memory) {
      pair.web->RecallSprings(*memory, entry.X_AB, &entry.springs);
    } else {
      pair.web->FindSprings(entry.X_AB, &entry.springs);
    }
  });
  found->size = 0;
  found->num_springs = 0;
  for (std::size_t i = 0; i < near.size(); ++i) {
    const SpringSet& springs = found->loaded[i].springs;
    if (springs.size() == 0 && springs.status == kNominal) continue;
    found->num_springs += springs.size();
    if (found->size != i) std::swap(found->loaded[found->size], found->loaded[i]);
    ++found->size;
  }
  return found;
}

std::shared_ptr<const Forces> ContactModel::ComputeForces(std::shared_ptr<const Found> found,
                                                          std::span<const Twist> V_FB,
                                                          const StepTable* table) const {
  if (table && table->forces && table->forces->found == found &&
      SameBits<Twist>(table->forces->V_FB, V_FB)) {
    return table->forces;
  }
  return PushBack(std::move(found), V_FB, table);
}

std::shared_ptr<const Forces> ContactModel::PushBack(std::shared_ptr<const Found> found,
                                                     std::span<const Twist> V_FB,
                                                     const StepTable* table) const {
  const std::shared_ptr<Forces> forces = forces_stock_.Take();
  forces->found = found;
  forces->V_FB.assign(V_FB.begin(), V_FB.end());
  forces->table_id = table ? table->id : 0;
  forces->springs.resize(found->num_springs);
  forces->stretches.resize(found->num_springs);
  forces->first.clear();
  std::size_t first = 0;
  for (std::size_t i = 0; i < found->size; ++i) {
    forces->first.push_back(first);
    first += found->loaded[i].springs.size();
  }
  const std::vector<Pose>* last_X_FB =
      table && table->forces ? &table->forces->found->X_FB : nullptr;
  std::vector<PairForce> totals(found->size);
  ParallelFor(static_cast<int>(found->size), threads_, [&](int i, int) {
    const PairSprings& loaded = found->loaded[i];
    const ContactPair& pair = pairs_[loaded.pair];
    const std::span stretches = forces->StretchesOf(i);
    if (pair.friction.anchored()) {
      const Pose last_X_AB = last_X_FB ? PoseOf(pair, *last_X_FB) : Pose{};
      const auto anchors = table ? table->StateOf(loaded.pair).anchors : nullptr;
      FindStretches(*pair.web, loaded.springs, loaded.X_AB, anchors.get(),
                    last_X_FB ? &last_X_AB : nullptr, stretches);
    }
    totals[i] =
        ComputePairForce(pair.law, pair.friction, loaded.springs, MotionOf(pair, found->X_FB, V_FB),
                         stretches, forces->SpringsOf(i));
  });
  // Summed in the order of the pairs, whichever thread computed them.
  forces->body_wrenches.assign(num_bodies_, {});
  forces->energetics = {};
  for (std::size_t i = 0; i < found->size; ++i) {
    AddWrenches(found->loaded[i], totals[i], forces.get());
  }
  return forces;
}

void ContactModel::AddWrenches(const PairSprings& loaded, const PairForce& total,
                               Forces* forces) const {
  const ContactPair& pair = pairs_[loaded.pair];
  const ContactGeometry &a = geometries_[pair.a], &b = geometries_[pair.b];
  const Pose &X_FA = forces->found->X_FB[a.body], &X_FB = forces->found->X_FB[b.body];
  // One force and one moment for the pair: what B gets is what A gets, turned round.
  const Mat3& R_FG = loaded.X_FA.R;
  const Vec3 force = R_FG * total.force;
  const Vec3 torque = R_FG * total.torque + Cross(X_FA.R * a.X_BG.p, force);
  Wrench &on_a = forces->body_wrenches[a.body], &on_b = forces->body_wrenches[b.body];
  on_a.force += force;
  on_a.torque += torque;
  on_b.force -= force;
  on_b.torque -= torque + Cross(X_FA.p - X_FB.p, force);
  forces->energetics += total.energetics;
}

Energetics ContactModel::Lost(const StepTable& table, const Forces& end, double duration) const {
  const Forces& start = *table.forces;
  Energetics sum = start.energetics;
  sum += end.energetics;
  const double lost = 0.5 * duration * (sum.damping_power + std::abs(sum.tangential_power));
  const double energy =
      sum.stored_normal + sum.stored_tangential + table.damping_loss + table.friction_loss;
  if (lost <= kLedgerTolerance * energy) {
    sum *= 0.5 * duration;
    return sum;
  }
  std::vector<Pose> X_FB(num_bodies_);
  std::vector<Twist> V_FB(num_bodies_);
  for (int i = 0; i < num_bodies_; ++i) {
    const BodyState halfway =
        Halfway({start.found->X_FB[i], start.V_FB[i]}, {end.found->X_FB[i], end.V_FB[i]}, duration);
    X_FB[i] = halfway.X_FB;
    V_FB[i] = halfway.V_FB;
  }
  Energetics halfway = ComputeForces(Find(X_FB, &table), V_FB, &table)->energetics;
  halfway *= 4;
  sum += halfway;
  sum *= duration / 6;
  return sum;
}

std::shared_ptr<const Forces> ContactModel::Coast(const StepTable& table, double duration) const {
  if (!table.forces) return nullptr;
  const Forces& start = *table.forces;
  std::vector<Pose> X_FB(num_bodies_);
  for (int i = 0; i < num_bodies_; ++i) {
    X_FB[i] = Coasted({start.found->X_FB[i], start.V_FB[i]}, duration);
  }
  return ComputeForces(Find(X_FB, &table), start.V_FB, &table);
}

std::shared_ptr<const StepTable> ContactModel::Advance(std::shared_ptr<const StepTable> table,
                                                       double time,
                                                       std::shared_ptr<const Forces> forces) const {
  const Forces* last = table->forces.get();
  if (last && time == table->time && SameBits<Pose>(last->found->X_FB, forces->found->X_FB) &&
      SameBits<Twist>(last->V_FB, forces->V_FB)) {
    return table;
  }
  if (time < table->time) {
    table = std::make_shared<StepTable>();
    last = nullptr;
  }
  if (forces->table_id != table->id) {
    forces = PushBack(forces->found, forces->V_FB, table.get());
  }
  const auto next = std::make_shared<StepTable>();
  next->id = NextTableId();
  next->time = time;
  if (last) {
    const Energetics lost = Lost(*table, *forces, time - table->time);
    next->damping_loss = table->damping_loss + lost.damping_power;
    next->friction_loss =
        table->friction_loss + lost.tangential_power -
        (forces->energetics.stored_tangential - last->energetics.stored_tangential);
  }
  next->pairs.resize(forces->found->size);
  std::atomic<bool> dragged = false;
  ParallelFor(static_cast<int>(forces->found->size), threads_, [&](int i, int) {
    const PairSprings& loaded = forces->found->loaded[i];
    const ContactPair& pair = pairs_[loaded.pair];
    PairState state = table->StateOf(loaded.pair);
    if (pair.friction.anchored()) {
      const auto before = state.anchors;
      state.anchors = UpdateAnchors(pair.friction, loaded.springs, loaded.X_AB,
                                    forces->StretchesOf(i), forces->SpringsOf(i), before);
      if (state.anchors != before) dragged.store(true, std::memory_order_relaxed);
    }
    const Pose last_X_AB = last ? PoseOf(pair, last->found->X_FB) : loaded.X_AB;
    state.memory = pair.web->Remember(loaded.springs, last_X_AB, loaded.X_AB, state.memory);
    next->pairs[i] = std::move(state);
  });
  next->forces = forces;
  // What was dragged pulls differently from here on, and the next step starts with that.
  if (dragged) next->forces = PushBack(forces->found, forces->V_FB, next.get());
  return next;
}

}  // namespace contact_toolkit
