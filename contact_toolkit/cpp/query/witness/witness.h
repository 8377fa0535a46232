// Every pair of facets of two meshes closer than a standoff, with witness points and features; the
// least distance; interference. All in frame A, from the relative pose alone.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <tuple>
#include <vector>

#include "base/column.h"
#include "base/columns.h"
#include "math/vec.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

// Rows in a fixed order given by the meshes and the pose, whatever the number of threads.
struct WitnessPairs {
  Column<double> distance;    // [m]; 0 where the facets cross
  Column<Vec3> p_ACa, p_ACb;  // witness points; equal where the facets cross
  Column<Vec3> normal_A;      // unit, from B towards A
  Column<std::int32_t> facet_a, facet_b;
  Column<Feature> feature_a, feature_b;
  Column<std::int32_t> multiplicity;  // facet pairs behind the row

  // The columns, and what Python calls them.
  template <class Self>
  static auto Columns(Self& self) {
    return std::tie(self.distance, self.p_ACa, self.p_ACb, self.normal_A, self.facet_a,
                    self.facet_b, self.feature_a, self.feature_b, self.multiplicity);
  }
  static constexpr std::array kColumnNames{"distance",  "p_ACa",     "p_ACb",
                                           "normal_A",  "facet_a",   "facet_b",
                                           "feature_a", "feature_b", "multiplicity"};

  std::size_t size() const { return distance.size(); }
  void Resize(std::size_t rows) { ResizeColumns(this, rows); }
};

struct WitnessOptions {
  bool merge =
      true;  // one row for all facet pairs whose closest points lie on the same two features
  int threads = 1;
};

void FindWitnessPairs(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                      double standoff, const WitnessOptions& options, WitnessPairs* pairs);

struct ClosestPair {
  double distance = std::numeric_limits<double>::infinity();  // infinity: none below upper_bound
  Vec3 p_ACa, p_ACb, normal_A;
  std::int32_t facet_a = -1, facet_b = -1;
  Feature feature_a{}, feature_b{};
};

ClosestPair FindDistance(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                         double upper_bound = std::numeric_limits<double>::infinity());

// [m] A lower bound of the distance, right to rounding; a poor one once it is known to be below
// `enough`.
double LeastDistance(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                     double enough);

// Whether any two facets touch or cross. A mesh wholly inside another does not intersect it here:
// surfaces, not solids.
bool Intersects(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB);

}  // namespace contact_toolkit
