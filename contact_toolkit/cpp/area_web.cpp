#include "area_web.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "clipped_integral.h"

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEquallyThick = 0.01;   // [-] share within which thicknesses count as equal
constexpr double kCellsInThickness = 8;  // of the smooth field: fewer would flatten a thin body
constexpr double kCellsInStandoff = 2;   // about an open surface, whose distance has a kink there
constexpr double kFinestCell = 1e-7;     // of the probed diagonal: cells are counted in 32 bits
constexpr double kCaptureShare = 0.98;   // of the largest depth: no distance is larger than that
constexpr double kSmoothedCells = 1.5;   // by which the smooth field flattens the largest depth

// The fields that nodes probe, each remembering what helps with the next node.
class ExactProbe {
 public:
  static constexpr bool kTellsSide = true;
  ExactProbe(const ProbedSurface& surface, const DistanceBounds& bounds)
      : surface_(surface), bounds_(bounds) {}
  // Whether the node at p certainly bears no load, found with less work than probing.
  bool Spares(const Vec3& p, double standoff) const { return bounds_.Beyond(p, 0, standoff); }
  FieldValue operator()(const Vec3& p) {
    const FieldValue value = surface_.Probe(p, hint_);
    hint_ = value.slot;
    return value;
  }

 private:
  const ProbedSurface& surface_;
  const DistanceBounds& bounds_;
  std::int32_t hint_ = -1;
};

class SmoothProbe {
 public:
  static constexpr bool kTellsSide = false;
  SmoothProbe(const SmoothField& field, const DistanceBounds& bounds)
      : field_(field), bounds_(bounds) {}
  bool Spares(const Vec3& p, double standoff) {
    const SmoothField::Above above = field_.IsAbove(p, standoff, &cursor_);
    if (above != SmoothField::Above::kUnknown) return above == SmoothField::Above::kYes;
    return bounds_.Beyond(p, 0, standoff + SmoothField::kDeviation * field_.cell());
  }
  FieldValue operator()(const Vec3& p) { return field_.Probe(p, &cursor_); }

 private:
  const SmoothField& field_;
  const DistanceBounds& bounds_;
  SmoothField::Cursor cursor_;
};

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

// The springs at one pose. Patch by patch: deformations at the nodes, integrals over the triangles,
// then a row for each node that bears load.
template <typename Probe>
class AreaWeb::Finder {
 public:
  Finder(const AreaWeb& web, Probe probe, const Pose& X_AB, SpringSet* springs)
      : web_(web),
        probe_(probe),
        X_AB_(X_AB),
        X_PS_(web.samples_a_ ? Inverse(X_AB) : X_AB),
        reach_(web.reach()),
        springs_(*springs) {}

  void Run() {
    const auto near = [&](const Sphere& sphere) {
      return !web_.bounds_->Beyond(X_PS_ * sphere.center, sphere.radius, reach_);
    };
    web_.nodes_->tree().ForEach(near, [&](std::int32_t index) {
      patch_ = &web_.nodes_->patch(index);
      if (nodes_.size() < patch_->nodes.size()) nodes_.resize(patch_->nodes.size());
      patch_->tree.ForEach(near, [&](std::int32_t leaf) {
        const auto [first, last] = patch_->leaves[leaf];
        for (std::int32_t i = first; i < last; ++i) Load(patch_->triangles[i]);
      });
      Emit(index);
      for (const std::int32_t node : touched_) nodes_[node].state = State::kUntouched;
      touched_.clear();
    });
  }

 private:
  enum class State : std::uint8_t { kUntouched, kFar, kProbed };
  struct Node {
    State state = State::kUntouched;
    Vec3 p;  // in the probed body
    double deformation = 0;
    double integral = 0;
    FieldValue field;
  };

  // Whether the node may be loaded: if not, its deformation need not be known.
  bool Touch(std::int32_t index) {
    Node& node = nodes_[index];
    if (node.state == State::kUntouched) {
      touched_.push_back(index);
      ++springs_.facet_pairs;
      node.integral = 0;
      node.p = X_PS_ * patch_->nodes[index];
      if (probe_.Spares(node.p, web_.options_.standoff)) {
        node.state = State::kFar;
      } else {
        ProbeAt(&node);
      }
    }
    return node.state == State::kProbed && node.deformation > 0;
  }

  void ProbeAt(Node* node) {
    node->field = probe_(node->p);
    node->deformation = web_.options_.standoff - node->field.phi;
    node->state = State::kProbed;
  }

  void Load(const AreaPatch::Triangle& triangle) {
    const auto [a, b, c] = triangle.node;
    const bool touches_a = Touch(a), touches_b = Touch(b), touches_c = Touch(c);
    if (!(touches_a || touches_b || touches_c)) return;
    std::array<double, 3> d;
    std::array<double*, 3> I;
    for (int j = 0; j < 3; ++j) {
      Node& node = nodes_[triangle.node[j]];
      if (node.state == State::kFar) ProbeAt(&node);
      d[j] = node.deformation;
      I[j] = &node.integral;
    }
    if (web_.options_.exponent == 1) {
      AddClippedIntegral(triangle.area, d, I);
    } else {
      AddClippedIntegral(triangle.area, d, web_.options_.exponent, I);
    }
    if (!web_.surface_->closed() && Crosses(triangle)) springs_.status |= kCrossed;
  }

  // Whether corners lie on both sides of an open surface.
  bool Crosses(const AreaPatch::Triangle& triangle) {
    bool front = false, back = false;
    for (const std::int32_t index : triangle.node) {
      Node& node = nodes_[index];
      if constexpr (!Probe::kTellsSide) node.field.side = web_.surface_->Probe(node.p).side;
      front |= node.field.side > 0;
      back |= node.field.side < 0;
    }
    return front && back;
  }

  void Emit(std::int32_t patch_index) {
    std::size_t row = springs_.size(), loaded = 0;
    for (const std::int32_t index : touched_) loaded += nodes_[index].integral > 0;
    Resize(row + loaded);
    const double K = web_.options_.stiffness, share = 1 / (web_.options_.exponent + 1);
    for (const std::int32_t index : touched_) {
      const Node& node = nodes_[index];
      if (!(node.integral > 0)) continue;
      const Vec3& gradient = node.field.gradient;
      if (-node.field.phi > web_.capture_depth_) springs_.status |= kBeyondCapture;
      const double elastic = K * node.integral;
      springs_.key[row] = static_cast<std::uint64_t>(patch_index) << 32 | index;
      springs_.deformation[row] = node.deformation;
      springs_.elastic[row] = elastic;
      // The energy is homogeneous of degree n + 1 in the deformations, whose derivatives are
      // elastic.
      springs_.energy[row] = share * elastic * node.deformation;
      springs_.stiffness[row] = K * patch_->weight[index];
      springs_.multiplicity[row] = 1;
      const Vec3 foot = node.p - node.field.phi * Normalized(gradient);
      if (web_.samples_a_) {
        springs_.p_AC[row] = springs_.p_ACa[row] = patch_->nodes[index];
        springs_.p_ACb[row] = X_AB_ * foot;
        springs_.gradient_A[row] = X_AB_.R * gradient;
      } else {
        springs_.p_AC[row] = springs_.p_ACb[row] = node.p;
        springs_.p_ACa[row] = foot;
        springs_.gradient_A[row] = -gradient;
      }
      ++row;
    }
  }

  void Resize(std::size_t rows) {
    springs_.key.resize(rows);
    springs_.deformation.resize(rows);
    springs_.elastic.resize(rows);
    springs_.energy.resize(rows);
    springs_.stiffness.resize(rows);
    springs_.p_AC.resize(rows);
    springs_.gradient_A.resize(rows);
    springs_.p_ACa.resize(rows);
    springs_.p_ACb.resize(rows);
    springs_.multiplicity.resize(rows);
  }

  const AreaWeb& web_;
  Probe probe_;
  const Pose X_AB_, X_PS_;
  const double reach_;
  SpringSet& springs_;
  const AreaPatch* patch_ = nullptr;
  // Kept by the thread for the next query; between patches all nodes are untouched.
  static inline thread_local std::vector<Node> nodes_;
  static inline thread_local std::vector<std::int32_t> touched_;
};

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

void AreaWeb::FindSprings(const Pose& X_AB, SpringSet* springs) const {
  springs->clear();
  if (smooth_) {
    Finder<SmoothProbe>(*this, SmoothProbe(*smooth_, *bounds_), X_AB, springs).Run();
  } else {
    Finder<ExactProbe>(*this, ExactProbe(*surface_, *bounds_), X_AB, springs).Run();
  }
  if (fillets_) fillets_->AddSprings(X_AB, springs);
}

}  // namespace contact_toolkit
