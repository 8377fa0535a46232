#include "area_web.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "area_loader.h"
#include "area_memory.h"
#include "area_probe.h"
#include "rounded_down.h"
#include "scratch.h"
#include "tolerances.h"

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEquallyThick = 0.01;   // [-] share within which thicknesses count as equal
constexpr double kCellsInThickness = 8;  // of the smooth field: fewer would flatten a thin body
constexpr double kCellsInStandoff = 2;   // about an open surface, whose distance has a kink there
constexpr double kFinestCell = 1e-7;     // of the probed diagonal: cells are counted in 32 bits
constexpr double kCaptureShare = 0.98;   // of the largest depth: no distance is larger than that
constexpr double kSmoothedCells = 1.5;   // by which the smooth field flattens the largest depth

bool SamplesA(const AreaBody& A, const AreaBody& B, AreaSide side) {
  if (side != AreaSide::kThinner) return side == AreaSide::kA;
  const bool a_closed = A.surface()->closed(), b_closed = B.surface()->closed();
  if (a_closed != b_closed) return a_closed;
  const double a = A.thickness(), b = B.thickness();
  if (std::abs(a - b) > kEquallyThick * std::max(a, b)) return a < b;
  return A.mesh().faces().size() >= B.mesh().faces().size();
}

void Require(bool good, const std::string& message) {
  if (!good) throw std::invalid_argument(message);
}

}  // namespace

AreaWeb::AreaWeb(std::shared_ptr<const AreaBody> A, std::shared_ptr<const AreaBody> B,
                 const AreaWebOptions& options)
    : options_(options), samples_a_(SamplesA(*A, *B, options.sampled)) {
  const auto finite_positive = [](double x) { return x > 0 && x < kInfinity; };
  Require(finite_positive(options.stiffness), "stiffness must be positive and finite");
  Require(options.exponent >= 1 && options.exponent <= 3, "exponent n must be between 1 and 3");
  Require(options.standoff >= 0 && options.standoff < kInfinity, "standoff must not be negative");
  Require(options.fillet >= 0 && options.fillet < kInfinity, "fillet must not be negative");
  Require(options.resolution >= 1e-4 && options.resolution <= 1,
          "resolution must be between 1e-4 and 1");
  const AreaBody& sampled = samples_a_ ? *A : *B;
  const AreaBody& probed = samples_a_ ? *B : *A;
  surface_ = probed.surface();
  Require(
      surface_->closed() || options.standoff > 0,
      "the probed body is an open surface, which has no inside to measure a penetration by; give "
      "the pair a standoff, or close the mesh");
  Require(!surface_->closed() || probed.mesh().volume() > 0,
          "the probed body is wound inside out; reverse its facets");
  if (options.fillet > 0) {
    fillets_ = std::make_unique<const EdgeFillets>(A->mesh(), B->mesh(), options.stiffness,
                                                   options.exponent, options.fillet);
  }
  spacing_ = options.resolution * std::min(A->mesh().diagonal(), B->mesh().diagonal());
  nodes_ = sampled.nodes(spacing_);
  bounds_ = probed.bounds(0.5 * spacing_);
  const double thickness = probed.thickness();
  capture_depth_ = surface_->closed() ? kCaptureShare * 0.5 * thickness : kInfinity;
  if (options.field == AreaField::kSmooth) {
    cell_ = 0.5 * spacing_;
    cell_ = std::min(cell_, surface_->closed() ? thickness / kCellsInThickness
                                               : options.standoff / kCellsInStandoff);
    cell_ = std::max(cell_, kFinestCell * probed.mesh().diagonal());
    capture_depth_ = std::min(capture_depth_, 0.5 * thickness - kSmoothedCells * cell_);
    if (!surface_->closed()) capture_depth_ = kInfinity;
    smooth_ = probed.smooth_field(cell_);
  }
}

double AreaWeb::reach() const { return options_.standoff + SmoothField::kDeviation * cell_; }

Pose AreaWeb::PoseOfSampled(const Pose& X_AB) const { return samples_a_ ? Inverse(X_AB) : X_AB; }

template <typename Function>
auto AreaWeb::WithProbe(const Function& function) const {
  return smooth_ ? function(SmoothProbe(*smooth_, *bounds_, options_.standoff))
                 : function(ExactProbe(*surface_, *bounds_, options_.standoff));
}

// `way(p, radius)`: how far the points of a ball may yet move.
template <typename Probe, typename Way>
void AreaWeb::Gather(const Pose& X_PS, const Way& way, Probe* probe,
                     AreaCandidates* candidates) const {
  const auto near = [&](const Sphere& sphere) {
    return !bounds_->Beyond(X_PS * sphere.center, sphere.radius,
                            reach() + way(sphere.center, sphere.radius));
  };
  const auto clearance = [&](const Vec3& p) { return probe->Clearance(X_PS * p, way(p, 0)); };
  GatherCandidates(*nodes_, near, clearance, candidates);
}

void AreaWeb::FindSprings(const Pose& X_AB, SpringSet* springs) const {
  auto& candidates = Scratch<AreaCandidates>([] {});
  WithProbe([&](auto probe) {
    const auto nowhere = [](const Vec3&, double) { return 0.0; };
    Gather(PoseOfSampled(X_AB), nowhere, &probe, &candidates);
    Loader(*this, candidates, probe, X_AB, springs).Run(0);
  });
  if (fillets_) fillets_->AddSprings(X_AB, springs);
}

void AreaWeb::RecallSprings(const WebMemory& memory, const Pose& X_AB, SpringSet* springs) const {
  const auto& near = static_cast<const AreaMemory&>(memory);
  const double motion = near.Motion(PoseOfSampled(X_AB));
  if (!(motion <= near.slack)) return FindSprings(X_AB, springs);
  if (smooth_) {
    const SmoothProbe probe(*smooth_, *bounds_, options_.standoff);
    Loader(*this, near.candidates, probe, X_AB, springs).Run(motion);
  } else {
    const RecallingProbe probe(*surface_, near.facets, motion);
    Loader(*this, near.candidates, probe, X_AB, springs).Run(motion);
  }
  if (fillets_) fillets_->AddSprings(X_AB, springs);
}

std::shared_ptr<const WebMemory> AreaWeb::Remember(const SpringSet& springs, const Pose& last_X_AB,
                                                   const Pose& X_AB,
                                                   std::shared_ptr<const WebMemory> before) const {
  if (springs.size() == 0) return nullptr;
  const Pose last_X_PS = PoseOfSampled(last_X_AB), X_PS = PoseOfSampled(X_AB);
  if (const auto* kept = static_cast<const AreaMemory*>(before.get())) {
    if (kept->Motion(X_PS) + MotionAround(kept->around, last_X_PS, X_PS) <= kept->slack) {
      return before;
    }
  }
  Sphere around = SphereAround(springs.p_AC.data(), springs.size());
  if (!samples_a_) around.center = Inverse(X_AB) * around.center;
  around.radius = std::max(around.radius, spacing_);
  const double slack = kAreaSlack * spacing_;
  // Gathering must serve at least one more step such as the last.
  if (!(2 * MotionAround(around, last_X_PS, X_PS) <= slack)) return nullptr;
  auto memory = std::make_shared<AreaMemory>();
  memory->X_PS = X_PS;
  memory->around = around;
  memory->slack = slack;
  WithProbe([&](auto probe) { GatherNear(&probe, memory.get()); });
  return memory;
}

template <typename Probe>
void AreaWeb::GatherNear(Probe* probe, AreaMemory* memory) const {
  const Pose& X_PS = memory->X_PS;
  const auto way = [&](const Vec3& p, double radius) { return memory->Way(p, radius); };
  AreaCandidates& candidates = memory->candidates;
  Gather(X_PS, way, probe, &candidates);
  for (AreaCandidates::Node& node : candidates.nodes) {
    if (node.clearance > 0) continue;
    const double above = (*probe)(-1, X_PS * node.p).phi - options_.standoff;
    node.clearance = RoundedDown(above / Probe::kSteepest);
  }
  memory->Prune();
  if (smooth_) return;
  for (const AreaCandidates::Node& node : candidates.nodes) {
    memory->facets.Add(surface_->mesh().bvh(), X_PS * node.p, memory->slack);
  }
}

}  // namespace contact_toolkit
