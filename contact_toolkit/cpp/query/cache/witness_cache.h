// Temporal coherence: facet pairs gathered once around a pose answer all queries near it.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "base/tolerances.h"
#include "math/vec.h"
#include "query/cache/feature_candidates.h"
#include "query/cache/row_merger.h"
#include "query/witness/witness.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

// [m] An upper bound of how far any point of B moves in A between two poses.
double LargestMotion(const CollisionMesh& B, const Pose& before, const Pose& after);

// All facet pairs within standoff + slack of each other at a reference pose, in the traversal's
// order, with their distances there. A distance changes at most as far as any point of B moves, so
// near that pose no other pair can come within the standoff, and most of those that cannot either
// are passed over untested. Those that can are mostly seen to be closest at the features they were
// closest at; only the others are measured from scratch. The meshes must outlive it.
class WitnessCandidates {
 public:
  WitnessCandidates(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                    double standoff, double slack);

  // Whether the answer at this pose is sure to be complete.
  bool Covers(const Pose& X_AB, double standoff) const { return standoff + Motion(X_AB) <= reach_; }

  // The same rows, bit for bit, as a query from scratch, and what had to be measured for that. Call
  // only where covered.
  void FindWitnessPairs(const Pose& X_AB, double standoff, bool merge, WitnessPairs* pairs,
                        MeasuredRows* measured) const;

  // Whether so many facet pairs would have to be measured at this pose, because they have changed
  // features, that gathering anew is the cheaper way on. Call only where covered.
  bool Worn(const Pose& X_AB, double standoff) const;

  // How many of the measured pairs were found on other features than are remembered.
  std::size_t Changed(const MeasuredRows& measured) const;

  // Whether most of these, judged by a few of them, are closest at the features found. Elsewhere,
  // as on exactly parallel faces, rounding decides features, and they are not worth remembering.
  bool MostlyCertain(const Pose& X_AB, const MeasuredRows& measured) const;

  // Remembers what was found instead.
  void Learn(const Pose& X_AB, const MeasuredRows& measured);

  std::size_t size() const { return candidates_.size(); }

 private:
  bool HasChanged(const MeasuredRows& measured, std::size_t i) const {
    return candidates_.features[measured.measured[i]].key() != measured.features[i].key();
  }

  // [m] How far B has moved since the reference pose.
  double Motion(const Pose& X_AB) const { return LargestMotion(B_, X_AB_, X_AB); }

  const CollisionMesh& A_;
  const CollisionMesh& B_;
  Pose X_AB_;
  double reach_;
  FacetCandidates candidates_;
  FeatureCandidates features_;
};

// Witness pairs along a motion. Candidates are gathered anew when the pose has left their slack,
// unless it moves so fast that they would not pay: then queries are answered from scratch, as is
// the first, from which nothing is known of the motion. They are gathered anew too when the motion
// has become too slow for so wide a slack. Where
// many pairs have had to be measured, their features are remembered instead of the old ones.
// Not to be shared between threads.
class WitnessCache {
 public:
  // slack [m]: 0 chooses one by the motion, at most a quarter of the query's standoff.
  WitnessCache(std::shared_ptr<const CollisionMesh> A, std::shared_ptr<const CollisionMesh> B,
               double slack);

  void FindWitnessPairs(const Pose& X_AB, double standoff, bool merge, WitnessPairs* pairs);

  int gathered() const { return gathered_; }  // how often candidates had to be gathered

  // Facet pairs that the last query measured one by one from among the candidates.
  std::size_t measured() const { return measured_.measured.size(); }

 private:
  double WidestSlack(double standoff) const;
  double SlackFor(double step, double widest) const;
  void Query(const Pose& X_AB, double standoff, bool merge, WitnessPairs* pairs);
  void LearnIfWorthwhile(const Pose& X_AB);

  std::shared_ptr<const CollisionMesh> A_, B_;
  double slack_;
  std::unique_ptr<WitnessCandidates> candidates_;
  std::optional<Pose> last_X_AB_;
  double last_standoff_ = 0;
  double width_ = 0;    // [m] the slack of the candidates
  double fastest_ = 0;  // [m] the largest of the motions watched
  int queries_ = 0;     // watched
  MeasuredRows measured_;
  std::size_t remeasured_ = 0;  // pairs measured for changed features since these were last learnt
  std::size_t learnt_ = 0;      // how many were, by the last query
  int in_vain_ = 0;             // how many times in a row that was no use
  int gathered_ = 0;
};

}  // namespace contact_toolkit
