// ContactModel, and what it is made of.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <string>

#include "bindings/body_arrays.h"
#include "contact/contact_model.h"
#include "web/facet_web.h"

namespace contact_toolkit {
namespace {

using Model = ContactModel;
using LoadedPointer = std::shared_ptr<const LoadedSprings>;
using ForcesPointer = std::shared_ptr<const Forces>;
using StatePointer = std::shared_ptr<const ContactState>;

std::vector<Pose> PosesOf(const Model& model, const NumbersIn& X_FB) {
  RequireBodies(X_FB, "X_FB", model.num_bodies(), {4, 4});
  std::vector<Pose> poses(model.num_bodies());
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = Pose::FromMatrix(X_FB.data() + 16 * i);
  return poses;
}

std::span<const Twist> TwistsOf(const Model& model, const NumbersIn& V_FB) {
  RequireBodies(V_FB, "V_FB", model.num_bodies(), {6});
  return {reinterpret_cast<const Twist*>(V_FB.data()), V_FB.shape(0)};
}

// Refuses what another model made: its pairs and webs are others.
void RequireOwn(const Model& model, const LoadedSprings& loaded, const char* name) {
  if (loaded.model_id == model.id()) return;
  throw nb::value_error((std::string(name) + " must come from this ContactModel or an equal one, "
                                             "and come from another; find the springs with this "
                                             "model")
                            .c_str());
}
void RequireOwn(const Model& model, const ContactState* state) {
  if (state == nullptr || state->model_id == 0 || state->model_id == model.id()) return;
  throw nb::value_error(
      "state must come from this ContactModel or an equal one, and comes from another; start from "
      "this model's initial_state()");
}

LoadedPointer Find(const Model& model, const NumbersIn& X_FB, const ContactState* state) {
  RequireOwn(model, state);
  const std::vector<Pose> poses = PosesOf(model, X_FB);
  const nb::gil_scoped_release release;
  return model.Find(poses, state);
}

ForcesPointer ComputeForces(const Model& model, const LoadedPointer& loaded, const NumbersIn& V_FB,
                            const ContactState* state) {
  RequireOwn(model, *loaded, "loaded springs");
  RequireOwn(model, state);
  const std::span<const Twist> twists = TwistsOf(model, V_FB);
  const nb::gil_scoped_release release;
  return model.ComputeForces(loaded, twists, state);
}

ForcesPointer Evaluate(const Model& model, const NumbersIn& X_FB, const NumbersIn& V_FB,
                       const ContactState* state) {
  RequireOwn(model, state);
  const std::vector<Pose> poses = PosesOf(model, X_FB);
  const std::span<const Twist> twists = TwistsOf(model, V_FB);
  const nb::gil_scoped_release release;
  return model.ComputeForces(model.Find(poses, state), twists, state);
}

void RequireFinite(double number, const char* name) {
  if (std::isfinite(number)) return;
  throw nb::value_error(
      (std::string(name) + " must be finite [s], not " + std::to_string(number)).c_str());
}

ForcesPointer Coast(const Model& model, const ContactState& state, double duration) {
  RequireOwn(model, &state);
  RequireFinite(duration, "duration");
  const nb::gil_scoped_release release;
  return model.Coast(state, duration);
}

StatePointer Advance(const Model& model, const StatePointer& state, double time,
                     const ForcesPointer& forces) {
  RequireOwn(model, state.get());
  RequireOwn(model, *forces->loaded, "forces");
  RequireFinite(time, "time");
  const nb::gil_scoped_release release;
  return model.Advance(state, time, forces);
}

Linearization Linearize(const Model& model, const NumbersIn& X_FB, const NumbersIn& V_FB,
                        const ContactState* state, bool symmetric) {
  RequireOwn(model, state);
  const std::vector<Pose> poses = PosesOf(model, X_FB);
  const std::span<const Twist> twists = TwistsOf(model, V_FB);
  const nb::gil_scoped_release release;
  return model.Linearize(poses, twists, state, symmetric ? Symmetry::kKept : Symmetry::kNone);
}

StatePointer AdvanceImplicitly(const Model& model, const StatePointer& state, double time,
                               const ForcesPointer& forces) {
  RequireOwn(model, state.get());
  RequireOwn(model, *forces->loaded, "forces");
  RequireFinite(time, "time");
  const nb::gil_scoped_release release;
  return model.AdvanceImplicitly(state, time, forces);
}

}  // namespace

void BindContact(nb::module_& m) {
  nb::class_<SpringWeb>(m, "SpringWeb").def_prop_ro("reach", &SpringWeb::reach);
  nb::enum_<Weighting>(m, "Weighting")
      .value("unit", Weighting::kUnit)
      .value("multiplicity", Weighting::kMultiplicity);
  nb::class_<FacetWeb, SpringWeb>(m, "FacetWeb")
      .def(nb::init<std::shared_ptr<const CollisionMesh>, std::shared_ptr<const CollisionMesh>,
                    double, double, double, Weighting>(),
           nb::arg("A"), nb::arg("B"), nb::arg("k"), nb::arg("n"), nb::arg("standoff"),
           nb::arg("weighting"));
  nb::class_<ContactGeometry>(m, "ContactGeometry")
      .def(
          "__init__",
          [](ContactGeometry* self, std::string name, std::shared_ptr<const CollisionMesh> mesh,
             int body, const PoseIn& X_BG) {
            new (self) ContactGeometry{std::move(name), std::move(mesh), body,
                                       Pose::FromMatrix(X_BG.data())};
          },
          nb::arg("name"), nb::arg("mesh"), nb::arg("body"), nb::arg("X_BG"));
  nb::class_<Friction>(m, "Friction")
      .def(
          "__init__",
          [](Friction* self, double static_coefficient, double dynamic_coefficient,
             double stiffness_ratio, double damping_time, double damping_slope) {
            new (self) Friction{static_coefficient, dynamic_coefficient, stiffness_ratio,
                                damping_time, damping_slope};
          },
          nb::arg("static_coefficient"), nb::arg("dynamic_coefficient"), nb::arg("stiffness_ratio"),
          nb::arg("damping_time"), nb::arg("damping_slope"));
  nb::class_<ContactPair>(m, "ContactPair")
      .def(
          "__init__",
          [](ContactPair* self, int a, int b, std::shared_ptr<const SpringWeb> web, double alpha,
             bool adhesion, double settling, double smallest, const Friction& friction) {
            new (self)
                ContactPair{a, b, std::move(web), {alpha, adhesion, settling, smallest}, friction};
          },
          nb::arg("a"), nb::arg("b"), nb::arg("web"), nb::arg("alpha"), nb::arg("adhesion"),
          nb::arg("settling"), nb::arg("smallest"), nb::arg("friction"));
  nb::class_<Model>(m, "ContactModel")
      .def(nb::init<int, std::vector<ContactGeometry>, std::vector<ContactPair>, int,
                    std::uint64_t>(),
           nb::arg("num_bodies"), nb::arg("geometries"), nb::arg("pairs"), nb::arg("threads"),
           nb::arg("id"))
      .def("find", &Find, nb::arg("X_FB"), nb::arg("state").none() = nb::none())
      .def("forces", &ComputeForces, nb::arg("loaded"), nb::arg("V_FB"),
           nb::arg("state").none() = nb::none())
      .def("evaluate", &Evaluate, nb::arg("X_FB"), nb::arg("V_FB"),
           nb::arg("state").none() = nb::none())
      .def(
          "eased",
          [](const Model& self, std::vector<double> depths, double start, double duration) {
            return std::const_pointer_cast<ContactState>(
                self.Eased({start, duration, std::move(depths)}));
          },
          nb::arg("depths"), nb::arg("start"), nb::arg("duration"))
      .def("linearize", &Linearize, nb::arg("X_FB"), nb::arg("V_FB"),
           nb::arg("state").none() = nb::none(), nb::arg("symmetric") = false)
      .def("coast", &Coast, nb::arg("state"), nb::arg("duration"))
      .def("advance", &Advance, nb::arg("state"), nb::arg("time"), nb::arg("forces"))
      .def("advance_implicitly", &AdvanceImplicitly, nb::arg("state"), nb::arg("time"),
           nb::arg("forces"));
}

}  // namespace contact_toolkit
