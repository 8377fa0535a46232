#include "contact/stretch.h"

#include <algorithm>
#include <optional>

#include "base/scratch.h"
#include "contact/stretch_exchange.h"

namespace contact_toolkit {
namespace {

inline Vec3 InPlane(const Vec3& v, const Vec3& normal) { return v - Dot(v, normal) * normal; }

// The offset of the anchor's points within the tangent plane.
inline Vec3 StretchOf(const Anchor& anchor, const Pose& X_AB, const Vec3& normal) {
  return InPlane(anchor.p_AQ - X_AB * anchor.p_BQ, normal);
}

// Of a spring that had no anchor; see FindStretches.
Vec3 OffsetSinceLastStep(const Vec3& p_AC, const Pose& X_AB, const Pose& last_X_BA) {
  return p_AC - X_AB * (last_X_BA * p_AC);
}
double ShareOf(const Vec3& offset, double deformation, const Vec3& normal) {
  const double approach = -Dot(offset, normal);
  if (!(approach > deformation)) return 1;  // touched all the while
  // A node may bear load without touching, by its facets' other corners: nothing to divide by.
  return deformation > 0 ? deformation / approach : 0.0;
}

void Hold(const Anchor& anchor, const Pose& X_AB, double weight, StretchSource* source) {
  source->held += weight * (anchor.p_AQ - X_AB * anchor.p_BQ);
  source->held_point += weight * anchor.p_AQ;
  source->held_weight += weight;
}

}  // namespace

void FindStretches(const SpringWeb& web, const SpringSet& springs, const Pose& X_AB,
                   const AnchorSet* anchors, const Pose* last_X_AB, std::span<Stretch> stretches,
                   StretchSources* sources) {
  // How much of its stiffness each anchor has left; springs stiffer than their anchor, or without.
  auto& kept = Scratch<std::vector<double>>([] {});
  auto& grown = Scratch<std::vector<std::size_t>>([] {});
  kept.assign(anchors ? anchors->anchors().size() : 0, 0.0);
  grown.clear();
  if (sources) {
    sources->rows.assign(springs.size(), {});
    sources->turned = {};
  }
  std::size_t next = 0;  // where the anchor is, if springs and anchors are in the same order
  for (std::size_t i = 0; i < springs.size(); ++i) {
    Stretch& row = stretches[i];
    row.anchor = anchors ? anchors->Find(springs.key[i], next) : -1;
    if (row.anchor < 0) {
      row = {};
      if (springs.stiffness[i] > 0) grown.push_back(i);
      continue;
    }
    next = row.anchor + 1;
    const Anchor& anchor = anchors->anchors()[row.anchor];
    row.sliding = anchor.sliding;
    row.stretch_A = StretchOf(anchor, X_AB, springs.normal_A[i]);
    if (sources) Hold(anchor, X_AB, 1, &sources->rows[i]);
    kept[row.anchor] = std::min(springs.stiffness[i], anchor.stiffness);
    if (springs.stiffness[i] > anchor.stiffness) grown.push_back(i);
  }
  if (grown.empty() || !last_X_AB) return;

  const Pose last_X_BA = Inverse(*last_X_AB);
  if (sources) sources->turned = X_AB.R * last_X_BA.R;
  std::optional<StretchExchange> exchange;
  if (anchors && web.CarriesStretch()) exchange.emplace(web, *anchors, kept);
  for (const std::size_t i : grown) {
    if (!(springs.stiffness[i] > 0)) continue;  // carries no friction
    Stretch& row = stretches[i];
    const Vec3& normal = springs.normal_A[i];
    const double owned = row.anchor >= 0 ? kept[row.anchor] : 0.0;
    double missing = springs.stiffness[i] - owned;
    Vec3 sum = owned * row.stretch_A;
    StretchSource* const source = sources ? &sources->rows[i] : nullptr;
    if (source) {
      *source = {};
      if (row.anchor >= 0) {
        Hold(anchors->anchors()[row.anchor], X_AB, owned / springs.stiffness[i], source);
      }
    }
    if (exchange) {
      for (const auto& [anchor, stiffness] : exchange->Take(springs.key[i], missing)) {
        sum += stiffness * StretchOf(*anchor, X_AB, normal);
        missing -= stiffness;
        if (source) Hold(*anchor, X_AB, stiffness / springs.stiffness[i], source);
        if (row.anchor < 0) row.sliding = row.sliding && anchor->sliding;
      }
    }
    const Vec3 offset = OffsetSinceLastStep(springs.p_AC[i], X_AB, last_X_BA);
    const double share = ShareOf(offset, springs.deformation[i], normal);
    sum += missing * (share * InPlane(offset, normal));
    if (source) {
      source->since = offset;
      source->weight = missing / springs.stiffness[i];
      source->share = share;
    }
    row.stretch_A = sum / springs.stiffness[i];
    row.anchor = -1;
  }
}

}  // namespace contact_toolkit
