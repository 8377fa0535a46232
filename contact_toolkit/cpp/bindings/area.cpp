#include "web/area/area_web.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>

#include "bindings/arrays.h"
#include "web/area/point_web.h"

namespace contact_toolkit {
namespace {

nb::dict Find(const AreaWeb& web, PoseIn X_AB) {
  SpringSet springs;
  {
    const nb::gil_scoped_release release;
    web.FindSprings(Pose::FromMatrix(X_AB.data()), &springs);
  }
  std::vector<Vec3> gradient_A(springs.size());
  for (std::size_t i = 0; i < springs.size(); ++i) {
    gradient_A[i] = springs.steepness[i] * springs.normal_A[i];
  }
  nb::dict rows;
  rows["key"] = ToNumpy<std::uint64_t>(std::move(springs.key));
  rows["deformation"] = ToNumpy(std::move(springs.deformation));
  rows["elastic"] = ToNumpy(std::move(springs.elastic));
  rows["energy"] = ToNumpy(std::move(springs.energy));
  rows["stiffness"] = ToNumpy(std::move(springs.stiffness));
  rows["p_AC"] = ToNumpy(std::move(springs.p_AC));
  rows["gradient_A"] = ToNumpy(std::move(gradient_A));
  rows["p_ACa"] = ToNumpy(std::move(springs.p_ACa));
  rows["p_ACb"] = ToNumpy(std::move(springs.p_ACb));
  rows["status"] = springs.status;
  rows["probed"] = springs.num_measured;
  return rows;
}

}  // namespace

void BindArea(nb::module_& m) {
  nb::enum_<AreaField>(m, "AreaField")
      .value("exact", AreaField::kExact)
      .value("smooth", AreaField::kSmooth);
  nb::enum_<AreaSide>(m, "AreaSide")
      .value("auto", AreaSide::kAuto)
      .value("a", AreaSide::kA)
      .value("b", AreaSide::kB);
  nb::enum_<Primitive::Kind>(m, "PrimitiveKind")
      .value("none", Primitive::Kind::kNone)
      .value("sphere", Primitive::Kind::kSphere)
      .value("capsule", Primitive::Kind::kCapsule)
      .value("cylinder", Primitive::Kind::kCylinder)
      .value("box", Primitive::Kind::kBox)
      .value("half_space", Primitive::Kind::kHalfSpace);
  nb::class_<AreaBody>(m, "AreaBody")
      .def(
          "__init__",
          [](AreaBody* self, std::shared_ptr<const Solid> solid, Primitive::Kind kind, double x,
             double y,
             double z) { new (self) AreaBody(std::move(solid), Primitive{kind, {x, y, z}}); },
          nb::arg("solid"), nb::arg("primitive") = Primitive::Kind::kNone, nb::arg("x") = 0.0,
          nb::arg("y") = 0.0, nb::arg("z") = 0.0)
      .def_prop_ro("thickness", &AreaBody::thickness);
  nb::class_<AreaWeb, SpringWeb>(m, "AreaWeb")
      .def(
          "__init__",
          [](AreaWeb* self, std::shared_ptr<AreaBody> A, std::shared_ptr<AreaBody> B,
             double stiffness, double n, double standoff, AreaField field, double resolution,
             AreaSide sampled, double fillet, double nominal_force) {
            const nb::gil_scoped_release release;
            new (self) AreaWeb(
                A, B, {stiffness, n, standoff, field, resolution, sampled, fillet, nominal_force});
          },
          nb::arg("A"), nb::arg("B"), nb::arg("stiffness"), nb::arg("n") = 1.0,
          nb::arg("standoff") = 0.0, nb::arg("field") = AreaField::kSmooth,
          nb::arg("resolution") = -1.0, nb::arg("sampled") = AreaSide::kAuto,
          nb::arg("fillet") = 0.0, nb::arg("nominal_force") = 0.0)
      .def("find", &Find, nb::arg("X_AB").noconvert())
      .def_prop_ro("samples_a", &AreaWeb::samples_a)
      .def_prop_ro("spacing", &AreaWeb::spacing)
      .def_prop_ro("cell", &AreaWeb::cell)
      .def_prop_ro("capture_depth", &AreaWeb::capture_depth);
  nb::class_<PointWeb, SpringWeb>(m, "PointWeb")
      .def(nb::init<bool, double, const AreaBody&, double, double>(), nb::arg("ball_is_a"),
           nb::arg("radius"), nb::arg("other"), nb::arg("stiffness"), nb::arg("standoff"));
}

}  // namespace contact_toolkit
