// From candidates to springs: deformations at the nodes, integrals over the triangles, then a row
// for each node that bears load. Nodes are probed only where that is needed.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "area_candidates.h"
#include "area_web.h"
#include "clipped_integral.h"
#include "scratch.h"

namespace contact_toolkit {

template <typename Probe>
class AreaWeb::Loader {
 public:
  Loader(const AreaWeb& web, const AreaCandidates& candidates, Probe probe, const Pose& X_AB,
         SpringSet* springs)
      : web_(web),
        nodes_(candidates.nodes),
        candidates_(candidates),
        probe_(probe),
        X_AB_(X_AB),
        X_PS_(web.PoseOfSampled(X_AB)),
        springs_(*springs),
        scratch_(Scratch<Memory>([] {})) {}

  // `motion` [m]: the nodes have moved by no more since they were given their clearances.
  void Run(double motion) {
    springs_.status = kNominal;
    springs_.facet_pairs = 0;
    scratch_.deformation.assign(nodes_.size(), kUnknown);
    scratch_.integral.assign(nodes_.size(), 0.0);
    if (scratch_.probed.size() < nodes_.size()) scratch_.probed.resize(nodes_.size());
    const auto count = static_cast<std::int32_t>(nodes_.size());
    for (std::int32_t i = 0; i < count; ++i) {
      if (!(nodes_[i].clearance > motion)) ProbeIfNear(i);
    }
    for (const AreaPatch::Triangle& triangle : candidates_.triangles) Load(triangle);
    Emit();
  }

 private:
  static constexpr double kUnknown = -std::numeric_limits<double>::infinity();

  struct Probed {
    Vec3 p;  // in the probed body
    FieldValue field;
  };
  struct Memory {
    std::vector<double> deformation;  // kUnknown unless probed
    std::vector<double> integral;
    std::vector<Probed> probed;
  };

  void ProbeAt(std::int32_t i) {
    Probed& node = scratch_.probed[i];
    node.p = X_PS_ * nodes_[i].p;
    node.field = probe_(i, node.p);
    Take(i);
  }

  void ProbeIfNear(std::int32_t i) {
    if constexpr (Probe::kStopsEarly) {
      Probed& node = scratch_.probed[i];
      node.p = X_PS_ * nodes_[i].p;
      if (probe_.IfNear(node.p, nodes_[i].clearance, &node.field)) Take(i);
    } else {
      ProbeAt(i);
    }
  }

  void Take(std::int32_t i) {
    ++springs_.facet_pairs;
    scratch_.deformation[i] = web_.options_.standoff - scratch_.probed[i].field.phi;
  }

  void Load(const AreaPatch::Triangle& triangle) {
    const auto [a, b, c] = triangle.node;
    const std::vector<double>& deformation = scratch_.deformation;
    if (!(deformation[a] > 0 || deformation[b] > 0 || deformation[c] > 0)) return;
    std::array<double, 3> d;
    std::array<double*, 3> I;
    for (int j = 0; j < 3; ++j) {
      const std::int32_t i = triangle.node[j];
      if (deformation[i] == kUnknown) ProbeAt(i);
      d[j] = deformation[i];
      I[j] = &scratch_.integral[i];
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
    for (const std::int32_t i : triangle.node) {
      Probed& node = scratch_.probed[i];
      if constexpr (!Probe::kTellsSide) node.field.side = web_.surface_->Probe(node.p).side;
      front |= node.field.side > 0;
      back |= node.field.side < 0;
    }
    return front && back;
  }

  void Emit() {
    const auto loaded = [](double integral) { return integral > 0; };
    springs_.Resize(std::ranges::count_if(scratch_.integral, loaded));
    std::size_t row = 0;
    std::int32_t i = 0;
    for (const AreaCandidates::Part& part : candidates_.parts) {
      for (; i < part.last_node; ++i) {
        if (loaded(scratch_.integral[i])) Write(part.patch, i, row++);
      }
    }
  }

  void Write(std::int32_t patch, std::int32_t i, std::size_t row) {
    const double K = web_.options_.stiffness, share = 1 / (web_.options_.exponent + 1);
    const AreaCandidates::Node& node = nodes_[i];
    const auto& [p, field] = scratch_.probed[i];
    const double deformation = scratch_.deformation[i], elastic = K * scratch_.integral[i];
    if (-field.phi > web_.capture_depth_) springs_.status |= kBeyondCapture;
    springs_.key[row] = static_cast<std::uint64_t>(patch) << 32 | node.index;
    springs_.deformation[row] = deformation;
    springs_.elastic[row] = elastic;
    // The energy is homogeneous of degree n + 1 in the deformations, whose derivatives are elastic.
    springs_.energy[row] = share * elastic * deformation;
    springs_.stiffness[row] = K * node.weight;
    springs_.multiplicity[row] = 1;
    const double steepness = Norm(field.gradient);
    const Vec3 normal = (steepness > 0 ? 1 / steepness : 0.0) * field.gradient;
    const Vec3 foot = p - field.phi * normal;
    springs_.steepness[row] = steepness;
    if (web_.samples_a_) {
      springs_.p_AC[row] = springs_.p_ACa[row] = node.p;
      springs_.p_ACb[row] = X_AB_ * foot;
      springs_.normal_A[row] = X_AB_.R * normal;
    } else {
      springs_.p_AC[row] = springs_.p_ACb[row] = p;
      springs_.p_ACa[row] = foot;
      springs_.normal_A[row] = -normal;
    }
  }

  const AreaWeb& web_;
  const std::vector<AreaCandidates::Node>& nodes_;
  const AreaCandidates& candidates_;
  Probe probe_;
  const Pose X_AB_, X_PS_;
  SpringSet& springs_;
  Memory& scratch_;
};

}  // namespace contact_toolkit
