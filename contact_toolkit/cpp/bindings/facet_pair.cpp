// The facet kernel alone, without a hierarchy: for benchmarks and tests.

#include "query/witness/facet_pair.h"

#include <nanobind/nanobind.h>

#include <algorithm>

#include "bindings/arrays.h"

namespace contact_toolkit {
namespace {

std::vector<std::int32_t> SlotsOfFacets(const CollisionMesh& mesh) {
  const std::vector<std::int32_t>& facets = mesh.bvh().slot_facet;
  std::vector<std::int32_t> slots(mesh.faces().size());
  for (std::size_t slot = 0; slot < facets.size(); ++slot) {
    slots[facets[slot]] = static_cast<std::int32_t>(slot);
  }
  return slots;
}

// Distances [m] of facets facet_a[i] of A and facet_b[i] of B.
nb::object FacetDistances(const CollisionMesh& A, const CollisionMesh& B, PoseIn X_AB,
                          ArrayIn<std::int32_t, Any> facet_a, ArrayIn<std::int32_t, Any> facet_b) {
  const std::size_t count = std::min(facet_a.shape(0), facet_b.shape(0));
  for (std::size_t i = 0; i < count; ++i) {
    const auto in = [](std::int32_t facet, const CollisionMesh& mesh) {
      return 0 <= facet && static_cast<std::size_t>(facet) < mesh.faces().size();
    };
    if (!in(facet_a(i), A) || !in(facet_b(i), B)) throw nb::index_error("no such facet");
  }
  std::vector<double> distances(count);
  {
    const nb::gil_scoped_release release;
    const PosedPair pair(A, B, Pose::FromMatrix(X_AB.data()));
    const std::vector<std::int32_t> slots_a = SlotsOfFacets(A), slots_b = SlotsOfFacets(B);
    FacetPairs chunk;
    for (std::size_t first = 0; first < count; first += chunk.count) {
      const std::size_t rest = count - first;
      chunk.count = static_cast<int>(std::min<std::size_t>(rest, FacetPairs::kCapacity));
      for (int k = 0; k < chunk.count; ++k) {
        chunk.slot_a[k] = slots_a[facet_a(first + k)];
        chunk.slot_b[k] = slots_b[facet_b(first + k)];
      }
      MeasureFacetPairs(pair, &chunk);
      std::copy_n(chunk.distance, chunk.count, &distances[first]);
    }
  }
  return ToNumpy(std::move(distances));
}

}  // namespace

void BindFacetPair(nb::module_& m) {
  m.def("facet_distances", &FacetDistances, nb::arg("A"), nb::arg("B"), nb::arg("X_AB"),
        nb::arg("facet_a"), nb::arg("facet_b"));
}

}  // namespace contact_toolkit
