#include "witness.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>

#include "arrays.h"
#include "simd/kernels.h"
#include "witness_cache.h"

namespace contact_toolkit {

static_assert(sizeof(Feature) == 2 * sizeof(std::int32_t));
template <>
struct Element<Feature> {
  using Scalar = std::int32_t;
  static constexpr std::size_t columns = 2;
};

namespace {

// Columns about as long as those of the last query, so that they need not grow row by row.
thread_local std::size_t last_rows = 0;

WitnessPairs RoomForRows() {
  WitnessPairs pairs;
  pairs.Reserve(last_rows + last_rows / 8 + FacetPairs::kCapacity);
  return pairs;
}

nb::dict Rows(WitnessPairs&& pairs) {
  last_rows = pairs.size();
  nb::dict rows;
  rows["distance"] = ToNumpy(std::move(pairs.distance));
  rows["p_ACa"] = ToNumpy(std::move(pairs.p_ACa));
  rows["p_ACb"] = ToNumpy(std::move(pairs.p_ACb));
  rows["normal_A"] = ToNumpy(std::move(pairs.normal_A));
  rows["facet_a"] = ToNumpy(std::move(pairs.facet_a));
  rows["facet_b"] = ToNumpy(std::move(pairs.facet_b));
  rows["feature_a"] = ToNumpy(std::move(pairs.feature_a));
  rows["feature_b"] = ToNumpy(std::move(pairs.feature_b));
  rows["multiplicity"] = ToNumpy(std::move(pairs.multiplicity));
  return rows;
}

nb::dict WitnessPairsOf(const CollisionMesh& A, const CollisionMesh& B, PoseIn X_AB,
                        double standoff, bool merge, int threads) {
  WitnessPairs pairs = RoomForRows();
  {
    const nb::gil_scoped_release release;
    FindWitnessPairs(A, B, Pose::FromMatrix(X_AB.data()), standoff, {merge, threads}, &pairs);
  }
  return Rows(std::move(pairs));
}

nb::dict CachedWitnessPairs(WitnessCache& cache, PoseIn X_AB, double standoff, bool merge) {
  WitnessPairs pairs = RoomForRows();
  {
    const nb::gil_scoped_release release;
    cache.FindWitnessPairs(Pose::FromMatrix(X_AB.data()), standoff, merge, &pairs);
  }
  return Rows(std::move(pairs));
}

nb::tuple FeatureTuple(const Feature& f) {
  return nb::make_tuple(static_cast<int>(f.kind), f.index);
}

nb::dict DistanceOf(const CollisionMesh& A, const CollisionMesh& B, PoseIn X_AB,
                    double upper_bound) {
  ClosestPair closest;
  {
    const nb::gil_scoped_release release;
    closest = FindDistance(A, B, Pose::FromMatrix(X_AB.data()), upper_bound);
  }
  nb::dict result;
  result["distance"] = closest.distance;
  result["p_ACa"] = ToNumpy(closest.p_ACa);
  result["p_ACb"] = ToNumpy(closest.p_ACb);
  result["normal_A"] = ToNumpy(closest.normal_A);
  result["facet_a"] = closest.facet_a;
  result["facet_b"] = closest.facet_b;
  result["feature_a"] = FeatureTuple(closest.feature_a);
  result["feature_b"] = FeatureTuple(closest.feature_b);
  return result;
}

bool IntersectsOf(const CollisionMesh& A, const CollisionMesh& B, PoseIn X_AB) {
  const nb::gil_scoped_release release;
  return Intersects(A, B, Pose::FromMatrix(X_AB.data()));
}

}  // namespace

void BindWitness(nb::module_& m) {
  m.def("witness_pairs", &WitnessPairsOf, nb::arg("A"), nb::arg("B"), nb::arg("X_AB"),
        nb::arg("standoff"), nb::arg("merge"), nb::arg("threads"));
  m.def("distance", &DistanceOf, nb::arg("A"), nb::arg("B"), nb::arg("X_AB"),
        nb::arg("upper_bound"));
  m.def("intersects", &IntersectsOf, nb::arg("A"), nb::arg("B"), nb::arg("X_AB"));
  nb::class_<WitnessCache>(m, "WitnessCache")
      .def(nb::init<std::shared_ptr<const CollisionMesh>, std::shared_ptr<const CollisionMesh>,
                    double>(),
           nb::arg("A"), nb::arg("B"), nb::arg("slack"))
      .def_prop_ro("gathered", &WitnessCache::gathered)
      .def_prop_ro("measured", &WitnessCache::measured)
      .def("witness_pairs", &CachedWitnessPairs, nb::arg("X_AB"), nb::arg("standoff"),
           nb::arg("merge"));
  m.def("simd", [] { return ActiveKernels().name; });
  m.def("select_simd", &SelectKernels, nb::arg("name"));
}

}  // namespace contact_toolkit
