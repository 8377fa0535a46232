#include "web/facet_slopes.h"

#include <cmath>

#include "web/spring_key.h"

namespace contact_toolkit {
namespace {

// The direction of an edge in its mesh.
Vec3 Along(const CollisionMesh& mesh, const Feature& edge) {
  const auto& [from, to] = mesh.edges()[edge.index];
  return Normalized(mesh.vertices()[to] - mesh.vertices()[from]);
}

// Two witness points and how they move when A does. Closest points stay on their features and
// the line between them square to both.
class MovingWitness {
 public:
  MovingWitness(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                const FeaturePair& features, const Vec3& p_a, const Vec3& apart, const Vec3& normal)
      : a_(features.a.kind), b_(features.b.kind), p_a_(p_a), apart_(apart), normal_(normal) {
    if (a_ == FeatureKind::kEdge) u_ = Along(A, features.a);
    if (b_ == FeatureKind::kEdge) v_ = X_AB.R * Along(B, features.b);
  }

  // Displacements in space of the points on A and on B.
  struct Change {
    Vec3 on_a, on_b;
  };

  Change By(const Vec3& rotation, const Vec3& translation) const {
    const Vec3 moved = translation + Cross(rotation, p_a_);
    if (b_ == FeatureKind::kFacet) return {moved, moved - Dot(normal_, moved) * normal_};
    if (a_ == FeatureKind::kFacet) {
      // The facet turns about Ao; the point on it stays opposite that of B.
      return {Dot(normal_, moved) * normal_ + Cross(rotation, apart_), {}};
    }
    // How far each point slides on its edge, beyond what A takes along: both components of
    // what separates them along the edges vanish before and after.
    const double on_a = -Dot(Cross(rotation, u_), apart_) - Dot(u_, moved);
    const double on_b = Dot(v_, moved);
    if (a_ == FeatureKind::kEdge && b_ == FeatureKind::kEdge) {
      const double c = Dot(u_, v_), s2 = 1 - c * c;
      if (!(s2 > 1e-12)) return {moved, {}};  // parallel: anywhere along them
      return {moved + ((on_a + c * on_b) / s2) * u_, ((on_b + c * on_a) / s2) * v_};
    }
    return {moved + on_a * u_, on_b * v_};
  }

 private:
  FeatureKind a_, b_;
  Vec3 p_a_, apart_, normal_;
  Vec3 u_, v_;  // along an edge of A, of B; zero for none
};

}  // namespace

void FindFacetSlopes(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                     double exponent, SpringSet* springs) {
  SpringSlopes& slopes = springs->slopes;
  slopes.clear();
  slopes.elastic.resize(springs->size());
  slopes.free.resize(springs->size());
  for (std::size_t i = 0; i < springs->size(); ++i) {
    const Vec3& normal = springs->normal_A[i];
    const Vec3 apart = springs->p_ACa[i] - springs->p_ACb[i];
    const double distance = Norm(apart);
    const FeaturePair features = FeaturesOf(springs->key[i]);
    const bool crossed = !(distance > 0) || (features.a.kind == FeatureKind::kFacet &&
                                             features.b.kind == FeatureKind::kFacet);
    const MovingWitness witness(A, B, X_AB, features, springs->p_ACa[i], apart, normal);
    FreeSlopes& free = slopes.free[i];
    Vec3 deformation[2];
    for (int k = 0; k < 6; ++k) {
      Vec3 rotation, translation;
      (k < 3 ? rotation : translation)[k % 3] = 1;
      if (crossed) {
        free.point[k] = 0.5 * (Cross(rotation, springs->p_AC[i]) - translation);
        free.gradient[k] = {};
        continue;
      }
      const auto [on_a, on_b] = witness.By(rotation, translation);
      const Vec3 change = on_a - on_b;
      const double farther = Dot(normal, change);
      deformation[k / 3][k % 3] = -farther;
      free.gradient[k] = (change - farther * normal) / distance;
      free.point[k] = 0.5 * (on_a + on_b) - translation;
    }
    free.deformation = {deformation[0], deformation[1]};
    free.stiffness = {};
    slopes.elastic[i] =
        (exponent * springs->elastic[i] / springs->deformation[i]) * free.deformation;
  }
}

}  // namespace contact_toolkit
