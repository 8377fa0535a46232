#include "contact/contact_model.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/parallel.h"
#include "base/same_bits.h"
#include "base/scratch.h"
#include "base/tolerances.h"
#include "contact/broad_phase.h"
#include "math/motion_bound.h"

namespace contact_toolkit {
namespace {

bool IsFinite(const Vec3& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

std::string NumbersOf(const Vec3& a) {
  char numbers[80];
  std::snprintf(numbers, sizeof numbers, "(%g, %g, %g)", a.x, a.y, a.z);
  return numbers;
}

}  // namespace

ContactModel::ContactModel(int num_bodies, std::vector<ContactGeometry> geometries,
                           std::vector<ContactPair> pairs, int threads, std::uint64_t id)
    : id_(id),
      num_bodies_(num_bodies),
      geometries_(std::move(geometries)),
      pairs_(std::move(pairs)),
      threads_(threads) {}

Pose ContactModel::PoseOf(const ContactPair& pair, std::span<const Pose> X_FB) const {
  const ContactGeometry &a = geometries_[pair.a], &b = geometries_[pair.b];
  return RelativePose(a.X_BG, RelativePose(X_FB[a.body], X_FB[b.body]) * b.X_BG);
}

double ContactModel::Moved(const ContactPair& pair, const Pose& before_X_AB,
                           const Pose& X_AB) const {
  const auto around = [](const CollisionMesh& mesh) {
    return Sphere{0.5 * (mesh.lower() + mesh.upper()), 0.5 * mesh.diagonal()};
  };
  const Sphere a = around(*geometries_[pair.a].mesh), b = around(*geometries_[pair.b].mesh);
  return a.radius < b.radius ? MotionAround(a, Inverse(before_X_AB), Inverse(X_AB))
                             : MotionAround(b, before_X_AB, X_AB);
}

Twist ContactModel::MotionOf(const ContactPair& pair, std::span<const Pose> X_FB,
                             std::span<const Twist> V_FB) const {
  const ContactGeometry &a = geometries_[pair.a], &b = geometries_[pair.b];
  const Pose& X_FA = X_FB[a.body];
  const Twist V_F = RelativeTwist(X_FA, V_FB[a.body], X_FB[b.body], V_FB[b.body]);
  const Mat3 R_GF = Transpose(X_FA.R * a.X_BG.R);
  return {R_GF * V_F.w, R_GF * VelocityAt(V_F, X_FA.R * a.X_BG.p)};
}

std::shared_ptr<LoadedSprings> ContactModel::NewLoadedSprings() const {
  const std::shared_ptr<LoadedSprings> loaded = loaded_stock_.Take();
  loaded->model_id = id_;
  return loaded;
}

bool ContactModel::FindPair(int index, std::span<const Pose> X_FB, const ContactState* state,
                            PairSprings* found) const {
  const ContactPair& pair = pairs_[index];
  const ContactGeometry& a = geometries_[pair.a];
  found->pair = index;
  found->X_FA = X_FB[a.body] * a.X_BG;
  found->X_AB = PoseOf(pair, X_FB);
  found->springs.withheld = state ? state->Withheld(index) : 0;
  if (std::isinf(found->springs.withheld)) {
    found->springs.clear();
    return true;
  }
  const auto stays_clear = [&](const Separation& apart) {
    return apart.clearance > 0 && Moved(pair, apart.X_AB, found->X_AB) <= apart.clearance;
  };
  const Separation* apart = state ? state->SeparationOf(index) : nullptr;
  if ((apart && stays_clear(*apart)) || stays_clear(found->known.apart)) {
    found->springs.clear();
    return true;
  }
  if (RecallPair(state, found)) return true;
  // Of a pair that may well be apart that is soon told.
  const double clearance =
      state && !(found->springs.withheld > 0) ? pair.web->Clearance(found->X_AB, 0) : 0;
  if (clearance > 0) {
    found->springs.clear();
    found->known.apart = {index, found->X_AB, clearance};
    return true;
  }
  pair.web->FindSprings(found->X_AB, &found->springs);
  return false;
}

bool ContactModel::RecallPair(const ContactState* state, PairSprings* found) const {
  const SpringWeb& web = *pairs_[found->pair].web;
  const auto recall = [&](const std::shared_ptr<const WebMemory>& memory) {
    return memory && web.RecallSprings(*memory, found->X_AB, &found->springs);
  };
  if (recall(found->known.memory)) return true;
  const std::shared_ptr<LatestMemory> latest = state ? state->StateOf(found->pair).memory : nullptr;
  if (!latest) return false;
  if (recall(latest->Get())) return true;
  const PairSprings* last = state->SpringsOf(found->pair);
  const auto around = last ? web.LookAround(last->springs, last->X_AB, found->X_AB) : nullptr;
  if (!recall(around)) return false;
  latest->Set(around);
  return true;
}

void ContactModel::LookAround(const Pose& last_X_AB, const ContactState* state,
                              PairSprings* found) const {
  found->known = {};
  if (!state) return;
  if (found->springs.size() == 0) {
    found->known.apart = SeparationOf(found->pair, last_X_AB, found->X_AB, *state);
  } else {
    found->known.memory =
        pairs_[found->pair].web->Remember(found->springs, last_X_AB, found->X_AB, nullptr);
  }
}

PairForce ContactModel::ComputePair(const PairSprings& found, std::span<const Pose> X_FB,
                                    std::span<const Twist> V_FB, const ContactState* state,
                                    std::span<Stretch> stretches,
                                    std::span<SpringForce> springs) const {
  const ContactPair& pair = pairs_[found.pair];
  if (pair.friction.anchored()) {
    const bool stepped = state && state->forces;
    const Pose last_X_AB = stepped ? PoseOf(pair, state->forces->loaded->X_FB) : Pose{};
    const auto anchors = state ? state->StateOf(found.pair).anchors : nullptr;
    FindStretches(*pair.web, found.springs, found.X_AB, anchors.get(),
                  stepped ? &last_X_AB : nullptr, stretches);
  }
  return ComputePairForce(pair.law, pair.friction, found.springs, MotionOf(pair, X_FB, V_FB),
                          stretches, springs);
}

std::shared_ptr<const LoadedSprings> ContactModel::Find(std::span<const Pose> X_FB,
                                                        const ContactState* state) const {
  if (state && state->forces && SameBits<Pose>(state->forces->loaded->X_FB, X_FB)) {
    return state->forces->loaded;
  }
  return FindLoaded(X_FB, state, false);
}

std::shared_ptr<LoadedSprings> ContactModel::FindLoaded(std::span<const Pose> X_FB,
                                                        const ContactState* state,
                                                        bool with_slopes) const {
  const std::shared_ptr<LoadedSprings> loaded = NewLoadedSprings();
  loaded->X_FB.assign(X_FB.begin(), X_FB.end());
  const std::vector<int> near = PairsInReach(geometries_, pairs_, X_FB);
  if (loaded->pairs.size() < near.size()) loaded->pairs.resize(near.size());
  ParallelFor(static_cast<int>(near.size()), threads_, [&](int i, int) {
    loaded->pairs[i].springs.slopes.wanted = with_slopes;
    loaded->pairs[i].known = {};
    FindPair(near[i], X_FB, state, &loaded->pairs[i]);
  });
  loaded->size = 0;
  loaded->num_springs = 0;
  loaded->idle.clear();
  for (std::size_t i = 0; i < near.size(); ++i) {
    const SpringSet& springs = loaded->pairs[i].springs;
    if (springs.size() == 0 && springs.status == kNominal) {
      loaded->idle.push_back(near[i]);
      continue;
    }
    loaded->num_springs += springs.size();
    if (loaded->size != i) std::swap(loaded->pairs[loaded->size], loaded->pairs[i]);
    ++loaded->size;
  }
  return loaded;
}

std::shared_ptr<const Forces> ContactModel::ComputeForces(
    std::shared_ptr<const LoadedSprings> loaded, std::span<const Twist> V_FB,
    const ContactState* state) const {
  if (state && state->forces && state->forces->loaded == loaded &&
      SameBits<Twist>(state->forces->V_FB, V_FB)) {
    return state->forces;
  }
  return EvaluateForces(std::move(loaded), V_FB, state);
}

std::shared_ptr<const Forces> ContactModel::EvaluateForces(
    std::shared_ptr<const LoadedSprings> loaded, std::span<const Twist> V_FB,
    const ContactState* state) const {
  const std::shared_ptr<Forces> forces = forces_stock_.Take();
  forces->loaded = loaded;
  forces->V_FB.assign(V_FB.begin(), V_FB.end());
  forces->state_id = state ? state->id : 0;
  forces->springs.resize(loaded->num_springs);
  forces->stretches.resize(loaded->num_springs);
  forces->first.clear();
  std::size_t first = 0;
  for (std::size_t i = 0; i < loaded->size; ++i) {
    forces->first.push_back(first);
    first += loaded->pairs[i].springs.size();
  }
  forces->pairs.resize(loaded->size);
  ParallelFor(static_cast<int>(loaded->size), threads_, [&](int i, int) {
    forces->pairs[i] = ComputePair(loaded->pairs[i], loaded->X_FB, V_FB, state,
                                   forces->StretchesOf(i), forces->SpringsOf(i));
  });
  AddUp(forces.get());
  return forces;
}

// In the order of the pairs, whichever thread computed them.
void ContactModel::AddUp(Forces* forces) const {
  forces->body_wrenches.assign(num_bodies_, {});
  forces->energetics = {};
  for (std::size_t i = 0; i < forces->loaded->size; ++i) {
    AddWrenches(forces->loaded->pairs[i], forces->pairs[i], forces);
  }
}

PairForce ContactModel::LinearizeFound(const PairSprings& found, std::span<const Pose> X_FB,
                                       std::span<const Twist> V_FB, const ContactState* state,
                                       Symmetry symmetry, PairLinearization* out) const {
  const ContactPair& pair = pairs_[found.pair];
  auto& stretches = Scratch<std::vector<Stretch>>([] {});
  auto& sources = Scratch<StretchSources>([] {});
  auto& forces = Scratch<std::vector<SpringForce>>([] {});
  forces.resize(found.springs.size());
  stretches.resize(found.springs.size());
  if (pair.friction.anchored()) {
    const bool stepped = state && state->forces;
    const Pose last_X_AB = stepped ? PoseOf(pair, state->forces->loaded->X_FB) : Pose{};
    const auto anchors = state ? state->StateOf(found.pair).anchors : nullptr;
    FindStretches(*pair.web, found.springs, found.X_AB, anchors.get(),
                  stepped ? &last_X_AB : nullptr, stretches, &sources);
  }
  return LinearizePair(pair.law, pair.friction, found.springs, MotionOf(pair, X_FB, V_FB),
                       stretches, forces, out, &sources, symmetry);
}

Linearization ContactModel::Linearize(std::span<const Pose> X_FB, std::span<const Twist> V_FB,
                                      const ContactState* state, Symmetry symmetry) const {
  const std::shared_ptr<const LoadedSprings> loaded = FindLoaded(X_FB, state, true);
  Linearization result;
  result.Resize(loaded->size);
  ParallelFor(static_cast<int>(loaded->size), threads_, [&](int i, int) {
    const PairSprings& entry = loaded->pairs[i];
    const ContactPair& pair = pairs_[entry.pair];
    const Twist V_A = MotionOf(pair, X_FB, V_FB);
    PairLinearization of_geometry;
    const PairForce total = LinearizeFound(entry, X_FB, V_FB, state, symmetry, &of_geometry);
    const ContactGeometry& a = geometries_[pair.a];
    const Mat3& R_FG = entry.X_FA.R;
    const Vec3 arm = X_FB[a.body].R * a.X_BG.p, force = R_FG * total.force;
    const PairLinearization of_body = ReferToBody(of_geometry, R_FG, arm, force, R_FG * V_A.w);
    result.pair[i] = entry.pair;
    result.bodies[i] = {a.body, geometries_[pair.b].body};
    result.wrench[i] = {R_FG * total.torque + Cross(arm, force), force};
    result.stiffness[i] = of_body.stiffness;
    result.damping[i] = of_body.damping;
  });
  return result;
}

void ContactModel::AddWrenches(const PairSprings& entry, const PairForce& total,
                               Forces* forces) const {
  const ContactPair& pair = pairs_[entry.pair];
  const ContactGeometry &a = geometries_[pair.a], &b = geometries_[pair.b];
  const Pose &X_FA = forces->loaded->X_FB[a.body], &X_FB = forces->loaded->X_FB[b.body];
  // One force and one moment for the pair: what B gets is what A gets, turned round.
  const Mat3& R_FG = entry.X_FA.R;
  const Vec3 force = R_FG * total.force;
  const Vec3 torque = R_FG * total.torque + Cross(X_FA.R * a.X_BG.p, force);
  const Vec3 about_b = torque + Cross(X_FA.p - X_FB.p, force);
  if (!IsFinite(force) || !IsFinite(torque) || !IsFinite(about_b)) {
    const Twist &V_FA = forces->V_FB[a.body], &V_FB = forces->V_FB[b.body];
    throw std::runtime_error(
        "pair " + std::to_string(entry.pair) + " ('" + a.name + "', '" + b.name +
        "'): the contact force is not finite: " + NumbersOf(force) + " N, " + NumbersOf(torque) +
        " N m, at relative velocities of " + NumbersOf(V_FA.v - V_FB.v) + " m/s and " +
        NumbersOf(V_FA.w - V_FB.w) +
        " rad/s. Velocities like these come of steps too long for the stiffness, or of an overlap "
        "at the start; where they are moderate, please report the two meshes and poses");
  }
  Wrench &on_a = forces->body_wrenches[a.body], &on_b = forces->body_wrenches[b.body];
  on_a.force += force;
  on_a.torque += torque;
  on_b.force -= force;
  on_b.torque -= about_b;
  forces->energetics += total.energetics;
}

}  // namespace contact_toolkit
