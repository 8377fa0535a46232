// One body's side of a pair of features: the feature, and how the facets around go on from it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "math/vec.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

// Fed with the facets around, whose corners are sorted by vertex so that all see an edge from the
// same end.
class FeatureSide {
 public:
  void Start(const CollisionMesh& mesh, const Feature& feature) {
    bvh_ = &mesh.bvh();
    is_facet_ = feature.kind == FeatureKind::kFacet;
    ends_ = feature.kind == FeatureKind::kEdge
                ? mesh.edges()[feature.index]
                : CollisionMesh::Couple{feature.index, feature.index};
    corners.clear();
    ways.clear();
    beyond_.clear();
    squared_longest = 0;
    last_slot_ = -1;
  }

  void AddFacet(std::int32_t slot) {
    if (slot == last_slot_) return;
    last_slot_ = slot;
    const double* at = &bvh_->slot_coordinates[9 * static_cast<std::size_t>(slot)];
    const auto& vertices = bvh_->slot_vertices[slot];
    const Vec3 p[3] = {{at[0], at[1], at[2]}, {at[3], at[4], at[5]}, {at[6], at[7], at[8]}};
    for (const Vec3& edge : {p[1] - p[0], p[2] - p[1], p[2] - p[0]}) {
      squared_longest = std::max(squared_longest, SquaredNorm(edge));
    }
    const bool first = corners.empty();
    for (int c = 0; first && c < 3; ++c) {
      if (Carries(vertices[c])) corners.push_back(p[c]);
    }
    for (int c = 0; c < 3; ++c) {
      if (Carries(vertices[c]) || std::ranges::count(beyond_, vertices[c]) > 0) continue;
      beyond_.push_back(vertices[c]);
      ways.push_back(p[c] - corners[0]);
    }
  }

  std::vector<Vec3> corners;   // of the feature [m]
  std::vector<Vec3> ways;      // from its first corner to the facets' others [m]
  double squared_longest = 0;  // [m²] of the facets' edges

 private:
  bool Carries(std::int32_t vertex) const {
    return is_facet_ || vertex == ends_[0] || vertex == ends_[1];
  }

  const Bvh* bvh_ = nullptr;
  bool is_facet_ = false;
  CollisionMesh::Couple ends_{};  // vertices of the feature, unless it is a facet
  std::int32_t last_slot_ = -1;
  std::vector<std::int32_t> beyond_;  // vertices the ways lead to
};

}  // namespace contact_toolkit
