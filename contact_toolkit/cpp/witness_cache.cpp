#include "witness_cache.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "facet_pair.h"
#include "row_merger.h"
#include "tolerances.h"
#include "traversal.h"

namespace contact_toolkit {

namespace {

FacetCandidates Gather(const PosedPair& pair, double reach) {
  FacetCandidates candidates;
  auto keep = [&](const FacetPairs& chunk) {
    for (int k = 0; k < chunk.count; ++k) {
      if (chunk.distance[k] > reach) continue;
      candidates.slot_a.push_back(chunk.slot_a[k]);
      candidates.slot_b.push_back(chunk.slot_b[k]);
      candidates.distance.push_back(chunk.distance[k]);
      candidates.features.push_back(FeaturesOf(pair, chunk, k));
    }
    return true;
  };
  Traversal(pair, reach, &keep).Run({0, 0});
  return candidates;
}

}  // namespace

WitnessCandidates::WitnessCandidates(const CollisionMesh& A, const CollisionMesh& B,
                                     const Pose& X_AB, double standoff, double slack)
    : A_(A),
      B_(B),
      X_AB_(X_AB),
      reach_(standoff + slack),
      candidates_(Gather(PosedPair(A, B, X_AB), reach_)),
      features_(PosedPair(A, B, X_AB), candidates_) {}

double WitnessCandidates::Motion(const Pose& X_AB) const {
  // |ΔR q + Δp| over B's bounding sphere, with the Frobenius norm of ΔR for its spectral norm.
  Mat3 change;
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    change.row[i] = X_AB.R.row[i] - X_AB_.R.row[i];
    squared += SquaredNorm(change.row[i]);
  }
  const Bvh& b = B_.bvh();
  const double turned = std::sqrt(squared) * Norm(b.half_extent);
  const double moved = Norm(change * b.origin + (X_AB.p - X_AB_.p));
  const double rounding = kTouching * (Norm(b.origin) + Norm(b.half_extent) + Norm(X_AB.p));
  return turned + moved + rounding;
}

std::size_t WitnessCandidates::FindWitnessPairs(const Pose& X_AB, double standoff, bool merge,
                                                WitnessPairs* pairs) const {
  pairs->Resize(0);
  const PosedPair pair(A_, B_, X_AB);
  const double near = standoff + Motion(X_AB);
  thread_local Column<FeatureWitness> witnesses;
  thread_local Column<std::int32_t> alone;
  thread_local MeasuredRows measured;
  changed_ += features_.Measure(pair, candidates_, near, &witnesses, &alone);
  measured.Measure(pair, candidates_, alone, standoff);
  RowMerger rows(pair, candidates_, features_, witnesses, measured, standoff, pairs);
  if (merge) {
    rows.WriteMerged();
  } else {
    rows.WriteSingle();
  }
  return alone.size();
}

WitnessCache::WitnessCache(std::shared_ptr<const CollisionMesh> A,
                           std::shared_ptr<const CollisionMesh> B, double slack)
    : A_(std::move(A)), B_(std::move(B)), slack_(slack) {}

void WitnessCache::FindWitnessPairs(const Pose& X_AB, double standoff, bool merge,
                                    WitnessPairs* pairs) {
  if (!candidates_ || !candidates_->Covers(X_AB, standoff) || candidates_->Worn()) {
    const double slack = slack_ > 0     ? slack_
                         : standoff > 0 ? standoff / 4
                                        : 1e-3 * std::min(A_->diagonal(), B_->diagonal());
    candidates_ = std::make_unique<WitnessCandidates>(*A_, *B_, X_AB, standoff, slack);
    ++gathered_;
  }
  measured_ = candidates_->FindWitnessPairs(X_AB, standoff, merge, pairs);
}

}  // namespace contact_toolkit
