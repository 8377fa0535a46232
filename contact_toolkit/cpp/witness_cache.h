// Temporal coherence: facet pairs gathered once around a pose answer all queries near it.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>

#include "feature_candidates.h"
#include "mesh.h"
#include "tolerances.h"
#include "vec.h"
#include "witness.h"

namespace contact_toolkit {

// All facet pairs within standoff + slack of each other at a reference pose, in the traversal's
// order, with their distances there. A distance changes at most as far as any point of B moves, so
// near that pose no other pair can come within the standoff, and most of those that cannot either
// are passed over untested. Those that can are mostly seen to be closest at the features they were
// closest at; only the others are measured from scratch. Immutable. The meshes must outlive it.
class WitnessCandidates {
 public:
  WitnessCandidates(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                    double standoff, double slack);

  // Whether the answer at this pose is sure to be complete.
  bool Covers(const Pose& X_AB, double standoff) const { return standoff + Motion(X_AB) <= reach_; }

  // The same rows, bit for bit, as a query from scratch. Call only where covered. Returns how many
  // facet pairs had to be measured from scratch.
  std::size_t FindWitnessPairs(const Pose& X_AB, double standoff, bool merge,
                               WitnessPairs* pairs) const;

  // Whether so many facet pairs have been measured because they changed features that gathering
  // anew is the cheaper way on.
  bool Worn() const { return changed_ > kWorn * size(); }

  std::size_t size() const { return candidates_.size(); }

 private:
  // [m] An upper bound of how far any point of B has moved in A since the reference pose.
  double Motion(const Pose& X_AB) const;

  const CollisionMesh& A_;
  const CollisionMesh& B_;
  Pose X_AB_;
  double reach_;
  FacetCandidates candidates_;
  FeatureCandidates features_;
  mutable std::atomic<std::size_t> changed_ = 0;  // pairs, in all queries; no answer depends on it
};

// Witness pairs along a motion: gathers candidates anew whenever the pose has left their slack, or
// they are worn.
// Not to be shared between threads.
class WitnessCache {
 public:
  // slack [m]: 0 chooses a quarter of each query's standoff.
  WitnessCache(std::shared_ptr<const CollisionMesh> A, std::shared_ptr<const CollisionMesh> B,
               double slack);

  void FindWitnessPairs(const Pose& X_AB, double standoff, bool merge, WitnessPairs* pairs);

  int gathered() const { return gathered_; }  // how often candidates had to be gathered

  // Facet pairs measured from scratch by the last query, after any gathering.
  std::size_t measured() const { return measured_; }

 private:
  std::shared_ptr<const CollisionMesh> A_, B_;
  double slack_;
  std::unique_ptr<const WitnessCandidates> candidates_;
  int gathered_ = 0;
  std::size_t measured_ = 0;
};

}  // namespace contact_toolkit
