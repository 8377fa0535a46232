#include "witness_cache.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "facet_pair.h"
#include "merge_table.h"
#include "row_writer.h"
#include "tolerances.h"
#include "traversal.h"

namespace contact_toolkit {

WitnessCandidates::WitnessCandidates(const CollisionMesh& A, const CollisionMesh& B,
                                     const Pose& X_AB, double standoff, double slack)
    : A_(A), B_(B), X_AB_(X_AB), reach_(standoff + slack) {
  const PosedPair pair(A, B, X_AB);
  auto keep = [&](const FacetPairs& chunk) {
    for (int k = 0; k < chunk.count; ++k) {
      if (chunk.distance[k] > reach_) continue;
      slot_a_.push_back(chunk.slot_a[k]);
      slot_b_.push_back(chunk.slot_b[k]);
      distance_.push_back(chunk.distance[k]);
    }
    return true;
  };
  Traversal(pair, reach_, &keep).Run({0, 0});
}

double WitnessCandidates::Motion(const Pose& X_AB) const {
  // |ΔR q + Δp| over B's bounding sphere. The spectral norm of a difference of rotations is its
  // Frobenius norm over √2.
  Mat3 change;
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    change.row[i] = X_AB.R.row[i] - X_AB_.R.row[i];
    squared += SquaredNorm(change.row[i]);
  }
  const Bvh& b = B_.bvh();
  const double turned = std::sqrt(0.5 * squared) * Norm(b.half_extent);
  const double moved = Norm(change * b.origin + (X_AB.p - X_AB_.p));
  const double rounding = kTouching * (Norm(b.origin) + Norm(b.half_extent) + Norm(X_AB.p));
  return turned + moved + rounding;
}

void WitnessCandidates::FindWitnessPairs(const Pose& X_AB, double standoff, bool merge,
                                         WitnessPairs* pairs) const {
  pairs->Resize(0);
  const PosedPair pair(A_, B_, X_AB);
  const double near = standoff + Motion(X_AB);
  thread_local MergeTable table;
  table.Clear();
  RowWriter write{pair, standoff, merge, &table, pairs};
  thread_local FacetPairs chunk;
  chunk.count = 0;
  const auto flush = [&] {
    MeasureFacetPairs(pair, &chunk);
    write(chunk);
    chunk.count = 0;
  };
  for (std::size_t i = 0; i < size(); ++i) {
    chunk.slot_a[chunk.count] = slot_a_[i];
    chunk.slot_b[chunk.count] = slot_b_[i];
    chunk.count += distance_[i] <= near;
    if (chunk.count == FacetPairs::kCapacity) flush();
  }
  flush();
}

WitnessCache::WitnessCache(std::shared_ptr<const CollisionMesh> A,
                           std::shared_ptr<const CollisionMesh> B, double slack)
    : A_(std::move(A)), B_(std::move(B)), slack_(slack) {}

void WitnessCache::FindWitnessPairs(const Pose& X_AB, double standoff, bool merge,
                                    WitnessPairs* pairs) {
  if (!candidates_ || !candidates_->Covers(X_AB, standoff)) {
    const double slack = slack_ > 0     ? slack_
                         : standoff > 0 ? standoff / 4
                                        : 1e-3 * std::min(A_->diagonal(), B_->diagonal());
    candidates_ = std::make_unique<WitnessCandidates>(*A_, *B_, X_AB, standoff, slack);
    ++gathered_;
  }
  candidates_->FindWitnessPairs(X_AB, standoff, merge, pairs);
}

}  // namespace contact_toolkit
