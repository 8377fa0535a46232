// Facet pairs between a kernel's raw answer (case, parameters) and a row of a result (witness
// points, features, normal).
#pragma once

#include "base/tolerances.h"
#include "kernels/kernels.h"
#include "math/vec.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

// Two meshes at a pose, with what the kernels need of it.
struct PosedPair {
  PosedPair(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB);

  const CollisionMesh& A;
  const CollisionMesh& B;
  Pose X_AB;
  double matrix[12];  // row-major rotation, then translation
  CullPose cull;
  double size;  // [m] largest coordinate in A: what rounding is relative to
  const Kernels& kernels = ActiveKernels();
};

// Runs the fast kernel on the chunk, and more careful ones on the pairs that need it.
void MeasureFacetPairs(const PosedPair& pair, FacetPairs* chunk);

struct FeaturePair {
  Feature a, b;
  // Unlike for distinct keys; zero for none.
  std::uint64_t key() const {
    const auto pack = [](const Feature& f) {
      return static_cast<std::uint64_t>(f.kind) << 30 | static_cast<std::uint32_t>(f.index);
    };
    return pack(a) << 32 | pack(b);
  }
};

struct Witness {
  double distance;
  Vec3 p_ACa, p_ACb, normal_A;
};

// What the kernels leave open where facets cross or touch: the point, and a direction.
void MendTouching(const PosedPair& pair, const FacetPairs& chunk, int k, Witness* witness);

// The features on which the closest points of entry k of a measured chunk lie.
FeaturePair FeaturesOf(const PosedPair& pair, const FacetPairs& chunk, int k);

// Entry k of a chunk's points or directions.
inline Vec3 At(const double (&x)[3][FacetPairs::kPadded], int k) {
  return {x[0][k], x[1][k], x[2][k]};
}

// Whether the kernels leave open its point or direction.
inline bool Touch(const PosedPair& pair, const FacetPairs& chunk, int k) {
  return chunk.distance[k] <= kTouching * pair.size;
}

// Its closest points, their distance, and the direction from B towards A.
inline Witness WitnessOf(const PosedPair& pair, const FacetPairs& chunk, int k) {
  Witness w{chunk.distance[k], At(chunk.point_a, k), At(chunk.point_b, k), At(chunk.normal, k)};
  if (Touch(pair, chunk, k)) MendTouching(pair, chunk, k, &w);
  return w;
}

}  // namespace contact_toolkit
