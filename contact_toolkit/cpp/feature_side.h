// One body's side of a pair of features: the feature, and how the facets around go on from it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "mesh.h"
#include "vec.h"

namespace contact_toolkit {

// Fed with the facets around, whose corners are sorted by vertex so that all see an edge from the
// same end.
class FeatureSide {
 public:
  void Start(const CollisionMesh& mesh, const Feature& feature) {
    mesh_ = &mesh;
    feature_ = feature;
    corners.clear();
    ways.clear();
    ends_.clear();
    squared_longest = 0;
    last_slot_ = -1;
  }

  void AddFacet(std::int32_t slot) {
    if (slot == last_slot_) return;
    last_slot_ = slot;
    const double* at = &mesh_->bvh().slot_coordinates[9 * static_cast<std::size_t>(slot)];
    const auto& vertices = mesh_->bvh().slot_vertices[slot];
    const Vec3 p[3] = {{at[0], at[1], at[2]}, {at[3], at[4], at[5]}, {at[6], at[7], at[8]}};
    for (const Vec3& edge : {p[1] - p[0], p[2] - p[1], p[2] - p[0]}) {
      squared_longest = std::max(squared_longest, SquaredNorm(edge));
    }
    if (corners.empty()) {
      for (int c = 0; c < 3; ++c) {
        if (Carries(vertices[c])) corners.push_back(p[c]);
      }
    }
    for (int c = 0; c < 3; ++c) {
      if (Carries(vertices[c]) || std::ranges::count(ends_, vertices[c]) > 0) continue;
      ends_.push_back(vertices[c]);
      ways.push_back(p[c] - corners[0]);
    }
  }

  std::vector<Vec3> corners;   // of the feature [m]
  std::vector<Vec3> ways;      // from its first corner to the facets' others [m]
  double squared_longest = 0;  // [m²] of the facets' edges

 private:
  bool Carries(std::int32_t vertex) const {
    if (feature_.kind == FeatureKind::kFacet) return true;
    if (feature_.kind == FeatureKind::kVertex) return vertex == feature_.index;
    const CollisionMesh::Couple& ends = mesh_->edges()[feature_.index];
    return vertex == ends[0] || vertex == ends[1];
  }

  const CollisionMesh* mesh_ = nullptr;
  Feature feature_{};
  std::int32_t last_slot_ = -1;
  std::vector<std::int32_t> ends_;
};

}  // namespace contact_toolkit
