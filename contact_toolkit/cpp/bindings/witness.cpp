#include "query/witness/witness.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>

#include "bindings/arrays.h"
#include "kernels/kernels.h"
#include "query/cache/witness_cache.h"

namespace contact_toolkit {

static_assert(sizeof(Feature) == 2 * sizeof(std::int32_t));
template <>
struct Element<Feature> {
  using Scalar = std::int32_t;
  static constexpr std::size_t columns = 2;
};

namespace {

// Columns about as long as those of the last query, so that they need not grow row by row. None
// where it found nothing: what is far mostly stays far, and taking blocks would be half the call.
thread_local std::size_t last_rows = 0;

WitnessPairs RoomForRows() {
  WitnessPairs pairs;
  if (last_rows > 0) ReserveColumns(&pairs, last_rows + last_rows / 8 + FacetPairs::kCapacity);
  return pairs;
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

ClosestPair DistanceOf(const CollisionMesh& A, const CollisionMesh& B, PoseIn X_AB,
                       double upper_bound) {
  const nb::gil_scoped_release release;
  return FindDistance(A, B, Pose::FromMatrix(X_AB.data()), upper_bound);
}

// Arrays and tuples are made when asked for: making all takes longer than many a query.
template <auto point>
Array<double> PointOf(const ClosestPair& pair) {
  return ToNumpy(pair.*point);
}
template <auto feature>
nb::tuple FeatureOf(const ClosestPair& pair) {
  return FeatureTuple(pair.*feature);
}

bool IntersectsOf(const CollisionMesh& A, const CollisionMesh& B, PoseIn X_AB) {
  const nb::gil_scoped_release release;
  return Intersects(A, B, Pose::FromMatrix(X_AB.data()));
}

}  // namespace

void BindWitness(nb::module_& m) {
  nb::class_<WitnessPairs> pairs(m, "WitnessPairs");
  pairs.def("__len__", &WitnessPairs::size);
  BindColumns(pairs);
  m.def("witness_pairs", &WitnessPairsOf, nb::arg("A"), nb::arg("B"), nb::arg("X_AB"),
        nb::arg("standoff"), nb::arg("merge"), nb::arg("threads"));
  nb::class_<ClosestPair>(m, "ClosestPair")
      .def_ro("distance", &ClosestPair::distance)
      .def_prop_ro("p_ACa", &PointOf<&ClosestPair::p_ACa>)
      .def_prop_ro("p_ACb", &PointOf<&ClosestPair::p_ACb>)
      .def_prop_ro("normal_A", &PointOf<&ClosestPair::normal_A>)
      .def_ro("facet_a", &ClosestPair::facet_a)
      .def_ro("facet_b", &ClosestPair::facet_b)
      .def_prop_ro("feature_a", &FeatureOf<&ClosestPair::feature_a>)
      .def_prop_ro("feature_b", &FeatureOf<&ClosestPair::feature_b>);
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
