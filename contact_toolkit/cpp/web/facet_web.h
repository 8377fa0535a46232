// The facet web: one spring for every merged pair of witness points closer than the standoff.
#pragma once

#include <cstdint>
#include <memory>

#include "query/witness/witness.h"
#include "shapes/mesh.h"
#include "web/spring_web.h"

namespace contact_toolkit {

enum class Weighting {
  kUnit,  // every merged pair counts once, as published; neither continuous nor conservative
  kMultiplicity,  // as often as the facet pairs behind it: continuous, and the gradient of a
                  // potential
};

// Spring i has the elastic force k w δⁿ with δ = standoff − distance and w by the weighting. Facets
// that cross have distance zero, hence the full standoff as deformation and no side any more: the
// status says so.
class FacetWeb final : public SpringWeb {
 public:
  FacetWeb(std::shared_ptr<const CollisionMesh> A, std::shared_ptr<const CollisionMesh> B, double k,
           double n, double standoff, Weighting weighting);

  void FindSprings(const Pose& X_AB, SpringSet* springs) const override;
  bool RecallSprings(const WebMemory& memory, const Pose& X_AB, SpringSet* springs) const override;
  std::shared_ptr<const WebMemory> Remember(const SpringSet& springs, const Pose& last_X_AB,
                                            const Pose& X_AB,
                                            std::shared_ptr<const WebMemory> before) const override;
  double Clearance(const Pose& X_AB, double enough) const override;
  double reach() const override { return standoff_; }
  bool CarriesStretch() const override { return true; }
  FeatureVertices VerticesOf(std::uint64_t key) const override;

 private:
  // The springs of witness pairs.
  void Load(const WitnessPairs& pairs, const Pose& X_AB, SpringSet* springs) const;

  std::shared_ptr<const CollisionMesh> A_, B_;
  double k_, n_, standoff_;
  Weighting weighting_;
};

}  // namespace contact_toolkit
