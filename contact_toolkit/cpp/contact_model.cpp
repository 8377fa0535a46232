#include "contact_model.h"

#include <cmath>
#include <cstring>
#include <utility>

#include "pair_forces.h"
#include "parallel.h"

namespace contact_toolkit {
namespace {

// Bounding box with faces along the axes of F.
struct Box {
  Vec3 center, half;
};

Box BoxInF(const ContactGeometry& geometry, const Pose& X_FB) {
  const Pose X_FG = X_FB * geometry.X_BG;
  const Vec3 half = 0.5 * (geometry.mesh->upper() - geometry.mesh->lower());
  Box box{X_FG * (0.5 * (geometry.mesh->lower() + geometry.mesh->upper())), {}};
  for (int i = 0; i < 3; ++i) {
    const Vec3& row = X_FG.R.row[i];
    box.half[i] = std::abs(row.x) * half.x + std::abs(row.y) * half.y + std::abs(row.z) * half.z;
  }
  return box;
}

bool Apart(const Box& a, const Box& b, double reach) {
  for (int i = 0; i < 3; ++i) {
    const double sum = a.half[i] + b.half[i] + reach;
    // Rounding of coordinates far from F's origin must not lose a pair.
    const double slack = 1e-14 * (std::abs(a.center[i]) + std::abs(b.center[i]) + sum);
    if (std::abs(a.center[i] - b.center[i]) > sum + slack) return true;
  }
  return false;
}

// Motion of geometry A relative to geometry B about A's origin, expressed in A.
Twist GeometryMotion(const ContactGeometry& a, const ContactGeometry& b, std::span<const Pose> X_FB,
                     std::span<const Twist> V_FB) {
  const Pose& X_FA = X_FB[a.body];
  const Twist V_F = RelativeTwist(X_FA, V_FB[a.body], X_FB[b.body], V_FB[b.body]);
  const Mat3 R_GF = Transpose(X_FA.R * a.X_BG.R);
  return {R_GF * V_F.w, R_GF * VelocityAt(V_F, X_FA.R * a.X_BG.p)};
}

template <typename T>
bool SameBits(std::span<const T> a, std::span<const T> b) {
  static_assert(sizeof(T) % sizeof(double) == 0);
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

}  // namespace

ContactModel::ContactModel(int num_bodies, std::vector<ContactGeometry> geometries,
                           std::vector<ContactPair> pairs, int threads)
    : num_bodies_(num_bodies),
      geometries_(std::move(geometries)),
      pairs_(std::move(pairs)),
      threads_(threads) {}

std::vector<int> ContactModel::PairsInReach(std::span<const Pose> X_FB) const {
  std::vector<Box> boxes;
  boxes.reserve(geometries_.size());
  for (const ContactGeometry& g : geometries_) boxes.push_back(BoxInF(g, X_FB[g.body]));
  std::vector<int> near;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const ContactPair& pair = pairs_[i];
    if (!Apart(boxes[pair.a], boxes[pair.b], pair.web->reach()))
      near.push_back(static_cast<int>(i));
  }
  return near;
}

std::shared_ptr<const Found> ContactModel::Find(std::span<const Pose> X_FB,
                                                const StepTable* table) const {
  if (table && table->forces && SameBits<Pose>(table->forces->found->X_FB, X_FB)) {
    return table->forces->found;
  }
  const std::shared_ptr<Found> found = found_stock_.Take();
  found->X_FB.assign(X_FB.begin(), X_FB.end());
  const std::vector<int> near = PairsInReach(X_FB);
  if (found->loaded.size() < near.size()) found->loaded.resize(near.size());
  ParallelFor(static_cast<int>(near.size()), threads_, [&](int i, int) {
    const ContactPair& pair = pairs_[near[i]];
    const ContactGeometry &a = geometries_[pair.a], &b = geometries_[pair.b];
    PairSprings& entry = found->loaded[i];
    entry.pair = near[i];
    entry.X_FA = X_FB[a.body] * a.X_BG;
    entry.X_AB = RelativePose(a.X_BG, RelativePose(X_FB[a.body], X_FB[b.body]) * b.X_BG);
    pair.web->FindSprings(entry.X_AB, &entry.springs);
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
                                                          const StepTable* /*table*/) const {
  const std::shared_ptr<Forces> forces = forces_stock_.Take();
  forces->found = found;
  forces->V_FB.assign(V_FB.begin(), V_FB.end());
  forces->springs.resize(found->num_springs);
  forces->first.clear();
  std::size_t first = 0;
  for (std::size_t i = 0; i < found->size; ++i) {
    forces->first.push_back(first);
    first += found->loaded[i].springs.size();
  }
  std::vector<PairForce> totals(found->size);
  ParallelFor(static_cast<int>(found->size), threads_, [&](int i, int) {
    const PairSprings& loaded = found->loaded[i];
    const ContactPair& pair = pairs_[loaded.pair];
    const ContactGeometry &a = geometries_[pair.a], &b = geometries_[pair.b];
    totals[i] = ComputePairForce(pair.law, loaded.springs, GeometryMotion(a, b, found->X_FB, V_FB),
                                 &forces->springs[forces->first[i]]);
  });
  // Summed in the order of the pairs, whichever thread computed them.
  forces->body_wrenches.assign(num_bodies_, {});
  forces->energetics = {};
  for (std::size_t i = 0; i < found->size; ++i) {
    const ContactPair& pair = pairs_[found->loaded[i].pair];
    const ContactGeometry &a = geometries_[pair.a], &b = geometries_[pair.b];
    const Pose &X_FA = found->X_FB[a.body], &X_FB = found->X_FB[b.body];
    // One force and one moment for the pair: what B gets is what A gets, turned round.
    const Mat3& R_FG = found->loaded[i].X_FA.R;
    const Vec3 force = R_FG * totals[i].force;
    const Vec3 torque = R_FG * totals[i].torque + Cross(X_FA.R * a.X_BG.p, force);
    Wrench &on_a = forces->body_wrenches[a.body], &on_b = forces->body_wrenches[b.body];
    on_a.force += force;
    on_a.torque += torque;
    on_b.force -= force;
    on_b.torque -= torque + Cross(X_FA.p - X_FB.p, force);
    forces->energetics += totals[i].energetics;
  }
  return forces;
}

std::shared_ptr<const StepTable> ContactModel::Advance(std::shared_ptr<const StepTable> table,
                                                       double time,
                                                       std::shared_ptr<const Forces> forces) const {
  const Forces* last = table->forces.get();
  if (last && time == table->time && SameBits<Pose>(last->found->X_FB, forces->found->X_FB) &&
      SameBits<Twist>(last->V_FB, forces->V_FB)) {
    return table;
  }
  const auto next = std::make_shared<StepTable>();
  next->time = time;
  if (last && time >= table->time) {
    const double half_step = 0.5 * (time - table->time);
    next->damping_loss = table->damping_loss + half_step * (last->energetics.damping_power +
                                                            forces->energetics.damping_power);
  }
  next->forces = std::move(forces);
  return next;
}

}  // namespace contact_toolkit
