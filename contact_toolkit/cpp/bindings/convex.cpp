#include <nanobind/nanobind.h>

#include "bindings/arrays.h"
#include "bindings/shapes.h"
#include "query/swept/gjk.h"
#include "query/swept/swept.h"
#include "query/witness/witness.h"

namespace contact_toolkit {
namespace {

using IndicesIn = ArrayIn<std::int32_t, Any>;

std::span<const Vec3> Points(const PointsIn& points) {
  return {reinterpret_cast<const Vec3*>(points.data()), points.shape(0)};
}

void MakePieces(ConvexPieces* self, PointsIn points, IndicesIn first) {
  const std::span all = Points(points);
  new (self) ConvexPieces({all.begin(), all.end()}, {first.data(), first.data() + first.shape(0)});
}

nb::object GjkOf(PointsIn a, PointsIn b, double bound) {
  if (a.shape(0) == 0 || b.shape(0) == 0) throw nb::value_error("each set needs a point");
  const GjkResult result = Gjk(Points(a), Points(b), bound);
  nb::dict answer;
  answer["distance"] = result.distance;
  answer["lower_bound"] = result.lower_bound;
  answer["p_A"] = ToNumpy(result.p_A);
  answer["p_B"] = ToNumpy(result.p_B);
  answer["normal"] = ToNumpy(result.normal);
  answer["status"] = static_cast<int>(result.status);
  answer["iterations"] = result.iterations;
  return answer;
}

// In the place of a feature's kind.
constexpr auto kPiece = static_cast<FeatureKind>(3);

Feature FeatureOf(const ConvexLeaves& shape, std::int32_t index) {
  return {shape.mesh() != nullptr ? FeatureKind::kFacet : kPiece, index};
}

// The closest pair where at least one shape is made of pieces.
ClosestPair DistanceOfPieces(nb::handle A, nb::handle B, PoseIn X_AB, double upper_bound) {
  const ConvexLeaves a = LeavesOf(A), b = LeavesOf(B);
  const Pose pose = Pose::FromMatrix(X_AB.data());
  const nb::gil_scoped_release release;
  const SweptDistance pair = FindSweptDistance(a, b, Motion(pose, pose), 0, upper_bound);
  return {pair.distance,
          pair.p_ACa,
          pair.p_ACb,
          Normalized(pair.p_ACa - pair.p_ACb),
          pair.facet_a,
          pair.facet_b,
          FeatureOf(a, pair.facet_a),
          FeatureOf(b, pair.facet_b)};
}

bool PiecesIntersect(nb::handle A, nb::handle B, PoseIn X_AB) {
  const ConvexLeaves a = LeavesOf(A), b = LeavesOf(B);
  const Pose pose = Pose::FromMatrix(X_AB.data());
  const nb::gil_scoped_release release;
  return SweptIntersects(a, b, Motion(pose, pose), 0);
}

}  // namespace

// After BindWitness, whose overloads for two meshes come first.
void BindConvex(nb::module_& m) {
  nb::class_<ConvexPieces>(m, "Pieces")
      .def("__init__", &MakePieces, nb::arg("points").noconvert(), nb::arg("first").noconvert())
      .def("__len__", &ConvexPieces::size)
      .def_prop_ro("lower", [](const ConvexPieces& self) { return ToNumpy(self.lower()); })
      .def_prop_ro("upper", [](const ConvexPieces& self) { return ToNumpy(self.upper()); });
  m.def("distance", &DistanceOfPieces, nb::arg("A"), nb::arg("B"), nb::arg("X_AB").noconvert(),
        nb::arg("upper_bound"));
  m.def("intersects", &PiecesIntersect, nb::arg("A"), nb::arg("B"), nb::arg("X_AB").noconvert());
  m.def("gjk", &GjkOf, nb::arg("a").noconvert(), nb::arg("b").noconvert(), nb::arg("bound"));
}

}  // namespace contact_toolkit
