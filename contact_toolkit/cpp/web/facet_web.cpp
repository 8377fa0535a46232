#include "web/facet_web.h"

#include <cmath>
#include <utility>

#include "base/scratch.h"
#include "base/tolerances.h"
#include "query/cache/witness_cache.h"
#include "web/facet_slopes.h"
#include "web/spring_key.h"

namespace contact_toolkit {
namespace {

std::array<std::int32_t, 3> VerticesOfFeature(const CollisionMesh& mesh, const Feature& feature) {
  switch (feature.kind) {
    case FeatureKind::kVertex:
      return {feature.index, -1, -1};
    case FeatureKind::kEdge:
      return {mesh.edges()[feature.index][0], mesh.edges()[feature.index][1], -1};
    case FeatureKind::kFacet:
      break;
  }
  return mesh.faces()[feature.index];
}

using MeshPointer = std::shared_ptr<const CollisionMesh>;

struct Candidates final : WebMemory {
  Candidates(MeshPointer A, MeshPointer B, const Pose& X_AB, double standoff, double slack)
      : A(std::move(A)), B(std::move(B)), pairs(*this->A, *this->B, X_AB, standoff, slack) {}
  MeshPointer A, B;  // a state may outlive its model, and go on with an equal one
  WitnessCandidates pairs;
};

}  // namespace

FacetWeb::FacetWeb(std::shared_ptr<const CollisionMesh> A, std::shared_ptr<const CollisionMesh> B,
                   double k, double n, double standoff, Weighting weighting)
    : A_(std::move(A)),
      B_(std::move(B)),
      k_(k),
      n_(n),
      standoff_(standoff),
      weighting_(weighting) {}

void FacetWeb::FindSprings(const Pose& X_AB, SpringSet* springs) const {
  auto& pairs = Scratch<WitnessPairs>([] {});
  FindWitnessPairs(*A_, *B_, X_AB, standoff_, {}, &pairs);
  Load(pairs, X_AB, springs);
}

bool FacetWeb::RecallSprings(const WebMemory& memory, const Pose& X_AB, SpringSet* springs) const {
  const auto& candidates = static_cast<const Candidates&>(memory).pairs;
  if (!candidates.Covers(X_AB, standoff_)) return false;
  auto& pairs = Scratch<WitnessPairs>([] {});
  auto& measured = Scratch<MeasuredRows>([] {});
  candidates.FindWitnessPairs(X_AB, standoff_, true, &pairs, &measured);
  Load(pairs, X_AB, springs);
  return true;
}

std::shared_ptr<const WebMemory> FacetWeb::Remember(const SpringSet& /*springs*/,
                                                    const Pose& last_X_AB, const Pose& X_AB,
                                                    std::shared_ptr<const WebMemory> before) const {
  const double motion = LargestMotion(*B_, last_X_AB, X_AB);
  const double slack = kCandidateSlack * standoff_;
  const auto* candidates = static_cast<const Candidates*>(before.get());
  if (candidates && candidates->pairs.Covers(X_AB, standoff_ + motion) &&
      !candidates->pairs.Worn(X_AB, standoff_)) {
    return before;
  }
  // Gathering must serve at least one more step such as the last.
  if (2 * motion > slack) return nullptr;
  return std::make_shared<Candidates>(A_, B_, X_AB, standoff_, slack);
}

double FacetWeb::Clearance(const Pose& X_AB, double enough) const {
  return LeastDistance(*A_, *B_, X_AB, enough + standoff_) - standoff_;
}

void FacetWeb::Load(const WitnessPairs& pairs, const Pose& X_AB, SpringSet* springs) const {
  springs->clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double deformation = standoff_ - pairs.distance[i] - springs->withheld;
    springs->num_measured += pairs.multiplicity[i];
    if (!(deformation > 0)) continue;
    if (pairs.distance[i] == 0) springs->status |= kCrossed;
    const double weight = weighting_ == Weighting::kUnit ? 1.0 : pairs.multiplicity[i];
    const double elastic = k_ * weight * (n_ == 1 ? deformation : std::pow(deformation, n_));
    springs->key.push_back(KeyOf({pairs.feature_a[i], pairs.feature_b[i]}));
    springs->deformation.push_back(deformation);
    springs->elastic.push_back(elastic);
    springs->energy.push_back(elastic * deformation / (n_ + 1));
    // Constant, so that what the tangential spring stores depends on its stretch alone: for n ≠ 1
    // the slope of the normal force at full deformation.
    springs->stiffness.push_back(k_ * weight * (n_ == 1 ? 1 : n_ * std::pow(standoff_, n_ - 1)));
    springs->p_AC.push_back(0.5 * (pairs.p_ACa[i] + pairs.p_ACb[i]));
    springs->normal_A.push_back(pairs.normal_A[i]);
    springs->steepness.push_back(1);
    springs->p_ACa.push_back(pairs.p_ACa[i]);
    springs->p_ACb.push_back(pairs.p_ACb[i]);
    springs->multiplicity.push_back(pairs.multiplicity[i]);
  }
  if (springs->slopes.wanted) FindFacetSlopes(*A_, *B_, X_AB, n_, springs);
}

FeatureVertices FacetWeb::VerticesOf(std::uint64_t key) const {
  const FeaturePair features = FeaturesOf(key);
  return {VerticesOfFeature(*A_, features.a), VerticesOfFeature(*B_, features.b)};
}

}  // namespace contact_toolkit
