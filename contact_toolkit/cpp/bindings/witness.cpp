#include "witness.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>

#include <type_traits>

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

// A column as a read-only array that keeps its rows alive: made when asked for, as making all nine
// takes longer than many a query.
template <auto column>
auto ColumnOf(nb::handle rows) {
  const auto& values = nb::cast<const WitnessPairs&>(rows).*column;
  using E = Element<typename std::remove_cvref_t<decltype(values)>::value_type>;
  return ViewOf<typename E::Scalar>(values, E::columns, rows);
}

WitnessPairs WitnessPairsOf(const CollisionMesh& A, const CollisionMesh& B, PoseIn X_AB,
                            double standoff, bool merge, int threads) {
  WitnessPairs pairs = RoomForRows();
  {
    const nb::gil_scoped_release release;
    FindWitnessPairs(A, B, Pose::FromMatrix(X_AB.data()), standoff, {merge, threads}, &pairs);
  }
  last_rows = pairs.size();
  return pairs;
}

WitnessPairs CachedWitnessPairs(WitnessCache& cache, PoseIn X_AB, double standoff, bool merge) {
  WitnessPairs pairs = RoomForRows();
  {
    const nb::gil_scoped_release release;
    cache.FindWitnessPairs(Pose::FromMatrix(X_AB.data()), standoff, merge, &pairs);
  }
  last_rows = pairs.size();
  return pairs;
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
  nb::class_<WitnessPairs>(m, "WitnessPairs")
      .def("__len__", &WitnessPairs::size)
      .def_prop_ro("distance", &ColumnOf<&WitnessPairs::distance>)
      .def_prop_ro("p_ACa", &ColumnOf<&WitnessPairs::p_ACa>)
      .def_prop_ro("p_ACb", &ColumnOf<&WitnessPairs::p_ACb>)
      .def_prop_ro("normal_A", &ColumnOf<&WitnessPairs::normal_A>)
      .def_prop_ro("facet_a", &ColumnOf<&WitnessPairs::facet_a>)
      .def_prop_ro("facet_b", &ColumnOf<&WitnessPairs::facet_b>)
      .def_prop_ro("feature_a", &ColumnOf<&WitnessPairs::feature_a>)
      .def_prop_ro("feature_b", &ColumnOf<&WitnessPairs::feature_b>)
      .def_prop_ro("multiplicity", &ColumnOf<&WitnessPairs::multiplicity>);
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
