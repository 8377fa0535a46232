#include "query/cache/witness_cache.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/scratch.h"
#include "base/tolerances.h"
#include "math/motion_bound.h"
#include "query/cache/row_merger.h"
#include "query/witness/facet_pair.h"
#include "query/witness/traversal.h"

namespace contact_toolkit {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

double LargestMotion(const CollisionMesh& B, const Pose& before, const Pose& after) {
  return MotionAround({B.bvh().origin, Norm(B.bvh().half_extent)}, before, after);
}

WitnessCandidates::WitnessCandidates(const CollisionMesh& A, const CollisionMesh& B,
                                     const Pose& X_AB, double standoff, double slack)
    : A_(A),
      B_(B),
      X_AB_(X_AB),
      reach_(standoff + slack),
      candidates_(Gather(PosedPair(A, B, X_AB), reach_)),
      features_(PosedPair(A, B, X_AB), candidates_) {}

void WitnessCandidates::FindWitnessPairs(const Pose& X_AB, double standoff, bool merge,
                                         WitnessPairs* pairs, MeasuredRows* measured) const {
  pairs->Resize(0);
  const PosedPair pair(A_, B_, X_AB);
  auto& witnesses = Scratch<Column<FeatureWitness>>([] {});
  measured->Clear();
  features_.Measure(pair, candidates_, standoff + Motion(X_AB), &witnesses, &measured->measured);
  measured->Measure(pair, candidates_, standoff);
  RowMerger rows(pair, candidates_, features_, witnesses, *measured, standoff, pairs);
  if (merge) {
    rows.WriteMerged();
  } else {
    rows.WriteSingle();
  }
}

bool WitnessCandidates::Worn(const Pose& X_AB, double standoff) const {
  auto& witnesses = Scratch<Column<FeatureWitness>>([] {});
  auto& alone = Scratch<Column<std::int32_t>>([] {});
  const std::size_t changed = features_.Measure(PosedPair(A_, B_, X_AB), candidates_,
                                                standoff + Motion(X_AB), &witnesses, &alone);
  return changed > kWorn * static_cast<double>(size());
}

void WitnessCandidates::Learn(const Pose& X_AB, const MeasuredRows& measured) {
  auto& changed = Scratch<Column<std::int32_t>>([] {});
  changed.clear();
  for (std::size_t i = 0; i < measured.measured.size(); ++i) {
    if (!HasChanged(measured, i)) continue;
    const std::int32_t k = measured.measured[i];
    candidates_.features[k] = measured.features[i];
    changed.push_back(k);
  }
  const PosedPair pair(A_, B_, X_AB);
  if (features_.Sparse()) {
    features_ = FeatureCandidates(pair, candidates_);
  } else {
    features_.Regroup(pair, candidates_, changed);
  }
}

std::size_t WitnessCandidates::Changed(const MeasuredRows& measured) const {
  std::size_t changed = 0;
  for (std::size_t i = 0; i < measured.measured.size(); ++i) {
    changed += HasChanged(measured, i);
  }
  return changed;
}

bool WitnessCandidates::MostlyCertain(const Pose& X_AB, const MeasuredRows& measured) const {
  const std::size_t stride = 1 + measured.measured.size() / kLearningSample;
  FacetCandidates sample;
  for (std::size_t i = 0; i < measured.measured.size(); i += stride) {
    if (!HasChanged(measured, i)) continue;
    const std::int32_t k = measured.measured[i];
    sample.slot_a.push_back(candidates_.slot_a[k]);
    sample.slot_b.push_back(candidates_.slot_b[k]);
    sample.distance.push_back(candidates_.distance[k]);
    sample.features.push_back(measured.features[i]);
  }
  const FeatureCandidates features(PosedPair(A_, B_, X_AB), sample);
  return 2 * features.Certain() > sample.size();
}

WitnessCache::WitnessCache(std::shared_ptr<const CollisionMesh> A,
                           std::shared_ptr<const CollisionMesh> B, double slack)
    : A_(std::move(A)), B_(std::move(B)), slack_(slack) {}

double WitnessCache::WidestSlack(double standoff) const {
  if (slack_ > 0) return slack_;
  return standoff > 0 ? standoff / 4 : 1e-3 * std::min(A_->diagonal(), B_->diagonal());
}

// A wide slack brings more candidates, a narrow one is soon left: the sum of both costs is least
// where the slack is in proportion to the root of the step.
double WitnessCache::SlackFor(double step, double widest) const {
  if (slack_ > 0) return slack_;
  return std::clamp(kSlackPerRoot * std::sqrt(widest * step), kNarrowest * widest, widest);
}

void WitnessCache::FindWitnessPairs(const Pose& X_AB, double standoff, bool merge,
                                    WitnessPairs* pairs) {
  Query(X_AB, standoff, merge, pairs);
  last_X_AB_ = X_AB;
  last_standoff_ = standoff;
}

void WitnessCache::Query(const Pose& X_AB, double standoff, bool merge, WitnessPairs* pairs) {
  measured_.Clear();
  const double widest = WidestSlack(standoff);
  const double step =
      last_X_AB_ ? LargestMotion(*B_, *last_X_AB_, X_AB) + std::abs(standoff - last_standoff_)
                 : kInfinity;
  fastest_ = std::max(fastest_, step);
  const bool slow = ++queries_ >= kQueriesWatched && kTooWide * SlackFor(fastest_, widest) < width_;
  if (!candidates_ || slow || !candidates_->Covers(X_AB, standoff)) {
    if (kWorthGathering * step > widest) {
      candidates_.reset();
      return contact_toolkit::FindWitnessPairs(*A_, *B_, X_AB, standoff, {merge, 1}, pairs);
    }
    width_ = SlackFor(slow ? fastest_ : step, widest);
    candidates_ = std::make_unique<WitnessCandidates>(*A_, *B_, X_AB, standoff, width_);
    ++gathered_;
    remeasured_ = learnt_ = 0, in_vain_ = 0;
  }
  if (queries_ >= kQueriesWatched) queries_ = 0, fastest_ = 0;
  candidates_->FindWitnessPairs(X_AB, standoff, merge, pairs, &measured_);
  LearnIfWorthwhile(X_AB);
}

void WitnessCache::LearnIfWorthwhile(const Pose& X_AB) {
  const std::size_t changed = candidates_->Changed(measured_);
  if (learnt_ > 0) {
    // Where it is in vain time and again, as on parallel faces, whose features rounding decides, it
    // is done less and less.
    in_vain_ = 2 * changed > learnt_ ? std::min(in_vain_ + 1, kMostInVain) : 0;
    learnt_ = 0;
  }
  remeasured_ += changed;
  const double patience = std::ldexp(1.0, std::max(0, in_vain_ - 1));
  const double cost =
      std::max(kLearning * static_cast<double>(candidates_->size()), kWorthLearning);
  if (static_cast<double>(remeasured_) < patience * cost) return;
  remeasured_ = 0;
  if (!candidates_->MostlyCertain(X_AB, measured_)) return;
  candidates_->Learn(X_AB, measured_);
  learnt_ = changed;
}

}  // namespace contact_toolkit
