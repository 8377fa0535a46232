#include "web/area/area_web.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "base/scratch.h"
#include "base/tolerances.h"
#include "math/rounded_down.h"
#include "query/witness/witness.h"
#include "web/area/area_loader.h"
#include "web/area/area_memory.h"
#include "web/area/area_probe.h"

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMuchThinner = 0.125;   // [-] fraction of a body's thickness: then it goes first
constexpr double kMuchFlatter = 0.25;    // [-] fraction of a body's surface: then it is probed
constexpr double kEquallyLarge = 0.01;   // [-] fraction within which sizes count as equal
constexpr double kCellsInThickness = 8;  // of the smooth field: fewer would flatten a thin body
constexpr double kCellsInStandoff = 2;   // about an open surface, whose distance has a kink there
constexpr double kFinestShell = 0.125;   // spacings: finer cells cost more than the exact field
constexpr double kFinestCell = 1e-7;     // of the probed diagonal: cells are counted in 32 bits
constexpr double kCaptureShare = 0.98;   // of the largest depth: no distance is larger than that
constexpr double kUsualResolution = 0.02, kFinestResolution = 5e-4;
// Node spacing over the radius of a round body's patch. On a lattice the force of a lying cylinder
// is good to 1.5 % at each pose, and on average as it rolls to 0.2 %.
constexpr double kBallShare = 0.35, kCylinderShare = 0.7, kLatticeShare = 1;
constexpr double kLatticeStretch = 2;     // spacings between nodes along a lying cylinder
constexpr double kWeightOfWater = 9.8e3;  // [N/m³]
constexpr double kCellShare = 0.01;       // of the smaller diagonal: the smooth field's usual cell
constexpr double kSmoothedCells = 1.5;    // by which the smooth field flattens the largest depth

// Whether a body with a round lattice meets sides that its triangles are cut by exactly.
bool LiesOn(const AreaBody& sampled, const AreaBody& probed, const AreaWebOptions& options) {
  using Kind = Primitive::Kind;
  const Kind round = sampled.surface()->primitive().kind, flat = probed.surface()->primitive().kind;
  return (round == Kind::kCapsule || round == Kind::kCylinder) &&
         (flat == Kind::kBox || flat == Kind::kHalfSpace) && options.exponent == 1 &&
         options.standoff == 0;
}

bool SamplesA(const AreaBody& A, const AreaBody& B, const AreaWebOptions& options) {
  if (options.sampled != AreaSide::kAuto) return options.sampled == AreaSide::kA;
  const bool a_closed = A.surface()->closed(), b_closed = B.surface()->closed();
  if (a_closed != b_closed) return b_closed;
  if (LiesOn(A, B, options)) return true;
  if (LiesOn(B, A, options)) return false;
  // A round body is probed, where it is known to be one: facets would make it rattle as it rolls.
  const bool a_round = A.surface()->primitive().roundness() > 0;
  const bool b_round = B.surface()->primitive().roundness() > 0;
  if (a_round != b_round) return b_round;
  if (A.thickness() < kMuchThinner * B.thickness()) return true;
  if (B.thickness() < kMuchThinner * A.thickness()) return false;
  if (std::abs(A.flatness() - B.flatness()) > kMuchFlatter) return A.flatness() < B.flatness();
  const double a = A.mesh().diagonal(), b = B.mesh().diagonal();
  if (std::abs(a - b) > kEquallyLarge * std::max(a, b)) return a < b;
  return A.mesh().faces().size() >= B.mesh().faces().size();
}

// [m] By the radius, or half the width, of the patch in which a round body presses on a flat one.
double NodeSpacing(const Primitive& round, double force, const AreaWebOptions& options,
                   double cylinder_share) {
  const double R = round.roundness(), n = options.exponent;
  if (!(R > 0)) return kInfinity;
  // A ball bears 2 π K R δ^{n+1} / (n + 1). A cylinder of length L bears no less than √(2 R) K L
  // δ^{n+1/2} per 4/3; it lies, as a rule.
  double depth =
      std::pow(force * (n + 1) / (2 * std::numbers::pi * options.stiffness * R), 1 / (n + 1));
  if (round.kind != Primitive::Kind::kSphere && round.size.y > 0) {
    depth = std::min(depth,
                     std::pow(0.75 * force / (options.stiffness * round.size.y * std::sqrt(2 * R)),
                              1 / (n + 0.5)));
  }
  const bool ball = round.kind == Primitive::Kind::kSphere;
  return (ball ? kBallShare : cylinder_share) * std::sqrt(2 * R * depth);
}

void Require(bool good, const std::string& message) {
  if (!good) throw std::invalid_argument(message);
}

}  // namespace

AreaWeb::AreaWeb(std::shared_ptr<const AreaBody> A, std::shared_ptr<const AreaBody> B,
                 const AreaWebOptions& options)
    : options_(options), samples_a_(SamplesA(*A, *B, options)) {
  const auto finite_positive = [](double x) { return x > 0 && x < kInfinity; };
  Require(finite_positive(options.stiffness), "stiffness must be positive and finite");
  Require(options.exponent >= 1 && options.exponent <= 3, "exponent n must be between 1 and 3");
  Require(options.standoff >= 0 && options.standoff < kInfinity, "standoff must not be negative");
  Require(options.fillet >= 0 && options.fillet < kInfinity, "fillet must not be negative");
  Require(options.resolution < 0 || (options.resolution >= 1e-4 && options.resolution <= 1),
          "resolution must be between 1e-4 and 1, or left out for what is needed");
  Require(options.nominal_force >= 0 && options.nominal_force < kInfinity,
          "nominal_force must not be negative");
  const AreaBody& sampled = samples_a_ ? *A : *B;
  const AreaBody& probed = samples_a_ ? *B : *A;
  sampled_ = sampled.shared_mesh();
  surface_ = probed.surface();
  overhang_ = probed.overhang();
  Require(surface_->closed() || options.standoff > 0,
          "the probed body has no inside to measure a penetration by; give the pair a standoff, or "
          "close the mesh");
  if (options.fillet > 0) {
    fillets_ = std::make_unique<const EdgeFillets>(A->mesh(), B->mesh(), options.stiffness,
                                                   options.exponent, options.fillet);
  }
  const double smaller = std::min(A->mesh().diagonal(), B->mesh().diagonal());
  spacing_ = (options.resolution > 0 ? options.resolution : kUsualResolution) * smaller;
  const bool lattice = LiesOn(sampled, probed, options);
  const Primitive& round = (lattice ? sampled : probed).surface()->primitive();
  double needed = spacing_;
  if (options.resolution < 0) {
    const double volume = std::min(std::abs(A->mesh().volume()), std::abs(B->mesh().volume()));
    const double force =
        options.nominal_force > 0 ? options.nominal_force : kWeightOfWater * volume;
    const double share = lattice ? kLatticeShare : kCylinderShare;
    needed = std::max(NodeSpacing(round, force, options, share), kFinestResolution * smaller);
  }
  RoundLattice nodes;
  if (lattice) {
    const double stretch = options.resolution < 0 ? kLatticeStretch : 1;
    nodes = {round, std::min(spacing_, needed), stretch * spacing_};
    rise_ = sampled.overhang();
    most_bulge_ = nodes.LargestBulge();
  } else {
    spacing_ = std::min(spacing_, needed);
  }
  if (const double R = surface_->primitive().roundness(); R > 0) {
    const double curvatures = surface_->primitive().kind == Primitive::Kind::kSphere ? 2 : 1;
    bulge_ = 0.5 * curvatures / (24 * R);
    most_bulge_ = bulge_ * 3 * spacing_ * spacing_;
  }
  nodes_ = sampled.nodes(spacing_, nodes);
  bounds_ = probed.bounds(0.5 * spacing_);
  const double thickness = probed.thickness();
  const double deepest = 0.5 * thickness;
  capture_depth_ = kInfinity;
  if (surface_->closed()) {
    // Nodes stand only so close to the deepest points, where the way out is lost; coarser ones tell
    // of the depth by chance.
    const double missed = 0.75 * spacing_;
    capture_depth_ = kCaptureShare * deepest;
    if (missed < deepest / 3) capture_depth_ = std::min(capture_depth_, deepest - missed);
  }
  const double in_shell = options.standoff / kCellsInStandoff;
  const bool fine = !surface_->closed() && in_shell < kFinestShell * spacing_;
  if (options.field == AreaField::kSmooth && !surface_->primitive() && !fine) {
    cell_ = std::min(kCellShare * smaller, 0.5 * spacing_);
    cell_ = std::min(cell_, surface_->closed() ? thickness / kCellsInThickness : in_shell);
    cell_ = std::max(cell_, kFinestCell * probed.mesh().diagonal());
    if (surface_->closed()) {
      capture_depth_ = std::min(capture_depth_, deepest - kSmoothedCells * cell_);
    }
    smooth_ = probed.smooth_field(cell_);
  }
  std::shared_ptr<const FlatRegions> flats;
  if (surface_->closed() && surface_->primitive().has_flat_sides()) {
    flats = probed.flats(0.5 * spacing_);
  }
  // Outside a wedge the distance is not linear, what is not the whole boundary tells nothing, and
  // only with n = 1 are pieces integrated exactly.
  const bool polyhedron =
      surface_->solid().kind() == SolidKind::kClosed && !(surface_->primitive().roundness() > 0);
  std::shared_ptr<const WedgeRegions> wedges;
  if (polyhedron && flats && !(options.standoff > 0) && options.exponent == 1) {
    wedges = probed.wedges(0.5 * spacing_);
  }
  grounds_ = AreaGrounds(std::move(flats), std::move(wedges), smooth_);
}

double AreaWeb::reach() const {
  return options_.standoff + most_bulge_ + SmoothField::kDeviation * cell_;
}

double AreaWeb::Clearance(const Pose& X_AB, double enough) const {
  // Fillets are felt before surfaces meet, and in a hole a distance changes its sign at once.
  if (fillets_ || surface_->solid().kind() == SolidKind::kNearlyClosed) return 0;
  const Pose X_PS = PoseOfSampled(X_AB);
  if (surface_->primitive().kind == Primitive::Kind::kHalfSpace) {  // larger than its mesh
    double least = kInfinity;
    for (const Vec3& vertex : sampled_->vertices()) {
      least = std::min(least, surface_->Probe(X_PS * vertex).phi);
    }
    return least - reach() - rise_;
  }
  const double nearer = reach() + overhang_ + rise_;
  const double least = LeastDistance(surface_->mesh(), *sampled_, X_PS, enough + nearer) - nearer;
  // Surfaces are apart, too, where one body is wholly in the other.
  const bool within = least > 0 && surface_->Probe(X_PS * sampled_->vertices()[0]).phi < 0;
  return within ? 0 : least;
}

Pose AreaWeb::PoseOfSampled(const Pose& X_AB) const { return samples_a_ ? Inverse(X_AB) : X_AB; }

template <typename Function>
auto AreaWeb::WithProbe(const Function& function) const {
  return smooth_ ? function(SmoothProbe(*smooth_, *bounds_, options_.standoff))
                 : function(ExactProbe(*surface_, *bounds_, options_.standoff + most_bulge_));
}

// `way(p, radius)`: how far the points of a ball may yet move; nowhere at one pose.
template <typename Probe, typename Way>
void AreaWeb::Gather(const Pose& X_PS, const Way& way, Probe* probe,
                     AreaCandidates* candidates) const {
  struct Test {
    const AreaWeb& web;
    const Pose& X_PS;
    const Way& way;
    Probe* probe;
    bool at_one_pose;

    bool MayLoad(const Sphere& sphere) const {
      return !web.bounds_->Beyond(X_PS * sphere.center, sphere.radius,
                                  web.reach() + web.rise_ + way(sphere.center, sphere.radius));
    }
    bool MayLoad(const Corners& corners) const {
      if (!web.surface_->primitive()) return MayLoad(SphereAround(corners.data(), 3));
      return LeastOver(corners) - web.nodes_->round().MostRise(corners) <=
             web.reach() + Farthest(corners);
    }
    // [m] Of the primitive that is probed.
    double LeastOver(const Corners& corners) const {
      Corners posed;
      for (int i = 0; i < 3; ++i) posed[i] = X_PS * corners[i];
      const Vec3 center = CenterOf(posed);
      const double least = web.surface_->primitive().LeastOver(posed, center);
      const double size = Norm(X_PS.p) + Norm(center) + Norm(posed[0] - center);
      return least - kTouching * (size + std::abs(least));
    }
    double Clearance(const Vec3& p) const { return probe->Clearance(X_PS * p, way(p, 0)); }
    double Farthest(const Corners& corners) const {
      return std::max({way(corners[0], 0), way(corners[1], 0), way(corners[2], 0)});
    }
    bool IsRound(const Corners& corners) const { return web.nodes_->round().IsRound(corners); }
    std::int32_t GroundUnder(const Corners& corners) const {
      return web.grounds_.Under(X_PS, corners, Farthest(corners));
    }
    float ClearanceAnywhere(const Corners& corners) const {
      return RoundedDown(LeastOver(corners) - web.reach());
    }
    bool IsNeverFlat(const Corners& corners) const {
      return at_one_pose || IsRound(corners) ||
             web.grounds_.IsNeverFlatUnder(X_PS, corners, Farthest(corners));
    }
    bool MayLoadAbove(const AreaPatch::Leaf& leaf, std::int32_t* side) const {
      *side = -1;
      if (web.nodes_->round()) return true;  // its triangles are not the surface
      const double farthest = way(leaf.around.center, leaf.around.radius);
      double height;
      *side = web.grounds_.SideUnder(X_PS, leaf, farthest, &height);
      return *side < 0 || !(height - farthest > web.options_.standoff);
    }
    float ClearanceAbove(std::int32_t ground, const Corners& corners) const {
      double most = -kInfinity;
      for (const std::int32_t side : web.grounds_.SidesOf(ground)) {
        const FlatSides::Side& plane = web.grounds_.side(side);
        double least = kInfinity;
        for (const Vec3& corner : corners) {
          least = std::min(least, Dot(plane.normal, X_PS * corner) - plane.offset);
        }
        most = std::max(most, least);
      }
      return RoundedDown(most - web.options_.standoff - web.nodes_->round().LargestBulge());
    }
  };
  const bool at_one_pose = !(way(Vec3{}, 0) > 0);
  CandidateGatherer(*nodes_, Test{*this, X_PS, way, probe, at_one_pose}, candidates).Run();
}

void AreaWeb::FindSprings(const Pose& X_AB, SpringSet* springs) const {
  auto& candidates = Scratch<AreaCandidates>([] {});
  WithProbe([&](auto probe) {
    const auto nowhere = [](const Vec3&, double) { return 0.0; };
    Gather(PoseOfSampled(X_AB), nowhere, &probe, &candidates);
    Loader(*this, candidates, probe, X_AB, springs).Run(0);
  });
  if (fillets_ && springs->withheld == 0) fillets_->AddSprings(X_AB, springs);
}

bool AreaWeb::RecallSprings(const WebMemory& memory, const Pose& X_AB, SpringSet* springs) const {
  const auto& near = static_cast<const AreaMemory&>(memory);
  const double motion = near.Motion(PoseOfSampled(X_AB));
  if (!(motion <= near.slack)) return false;
  if (smooth_) {
    const SmoothProbe probe(*smooth_, *bounds_, options_.standoff);
    Loader(*this, near.candidates, probe, X_AB, springs).Run(motion);
  } else {
    const RecallingProbe probe(*surface_, near.facets, motion);
    Loader(*this, near.candidates, probe, X_AB, springs).Run(motion);
  }
  if (fillets_ && springs->withheld == 0) fillets_->AddSprings(X_AB, springs);
  return true;
}

std::shared_ptr<const WebMemory> AreaWeb::Remember(const SpringSet& springs, const Pose& last_X_AB,
                                                   const Pose& X_AB,
                                                   std::shared_ptr<const WebMemory> before) const {
  if (springs.size() == 0) return nullptr;
  const Pose last_X_PS = PoseOfSampled(last_X_AB), X_PS = PoseOfSampled(X_AB);
  if (const auto* kept = static_cast<const AreaMemory*>(before.get())) {
    const double moved = MotionAround(kept->around, last_X_PS, X_PS);
    const bool serves = kept->Motion(X_PS) + moved <= kept->slack;
    if (serves && kept->slack <= kMuchSlack * SlackFor(moved)) return before;
  }
  const Sphere around = Around(springs, X_AB);
  const double moved = MotionAround(around, last_X_PS, X_PS), slack = SlackFor(moved);
  // Gathering must serve at least one more step such as the last.
  return 2 * moved <= slack ? GatherNear(X_PS, around, slack) : nullptr;
}

std::shared_ptr<const WebMemory> AreaWeb::LookAround(const SpringSet& last_springs,
                                                     const Pose& last_X_AB,
                                                     const Pose& X_AB) const {
  const Pose last_X_PS = PoseOfSampled(last_X_AB), X_PS = PoseOfSampled(X_AB);
  const Sphere around = Around(last_springs, last_X_AB);
  return GatherNear(X_PS, around, SlackFor(MotionAround(around, last_X_PS, X_PS)));
}

Sphere AreaWeb::Around(const SpringSet& springs, const Pose& X_AB) const {
  Sphere around = SphereAround(springs.p_AC.data(), springs.size());
  if (!samples_a_) around.center = Inverse(X_AB) * around.center;
  around.radius = std::max(around.radius, spacing_);
  return around;
}

double AreaWeb::SlackFor(double moved) const {
  const double spacing = nodes_->round() ? nodes_->round().across : spacing_;
  return std::clamp(kSlackSteps * moved, kLeastAreaSlack * spacing, kAreaSlack * spacing);
}

std::shared_ptr<const AreaMemory> AreaWeb::GatherNear(const Pose& X_PS, const Sphere& around,
                                                      double slack) const {
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
    if (!(node.clearance <= 0)) continue;
    const Vec3 p = X_PS * node.p;
    const FieldValue field = (*probe)(-1, p);
    const double above = field.phi - options_.standoff - most_bulge_;
    node.clearance = RoundedDown(probe->SafeWay(p, field, above));
  }
  for (std::size_t t = 0; t < candidates.triangles.size(); ++t) {
    const AreaCandidates::Triangle& triangle = candidates.triangles[t];
    if (triangle.ground != AreaCandidates::kSmallest) continue;
    const auto& [a, b, c] = triangle.node;
    candidates.clearances[t] =
        std::min({candidates.nodes[a].clearance, candidates.nodes[b].clearance,
                  candidates.nodes[c].clearance});
  }
  memory->Prune(grounds_.has_wedges());
  if (smooth_ || surface_->primitive()) return;
  for (const AreaCandidates::Node& node : candidates.nodes) {
    if (std::isnan(node.clearance)) {
      memory->facets.Skip();
    } else {
      memory->facets.Add(surface_->mesh().bvh(), X_PS * node.p, memory->slack);
    }
  }
}

}  // namespace contact_toolkit
