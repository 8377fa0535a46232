// ContactModel and the immutable objects it hands out.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <set>
#include <string>

#include "arrays.h"
#include "contact_arrays.h"
#include "contact_model.h"
#include "facet_web.h"

namespace contact_toolkit {
namespace {

using NumbersIn = nb::ndarray<const double, nb::device::cpu, nb::c_contig>;
using Model = ContactModel;
using FoundPointer = std::shared_ptr<const Found>;
using ForcesPointer = std::shared_ptr<const Forces>;
using TablePointer = std::shared_ptr<const StepTable>;

// Refuses what is not a finite array of one entry a body; says what was found.
void RequireBodies(const NumbersIn& array, const char* name, int bodies,
                   std::initializer_list<std::size_t> entry) {
  bool right = array.ndim() == entry.size() + 1 && array.shape(0) == static_cast<size_t>(bodies);
  std::string wanted = std::to_string(bodies), given;
  std::size_t stride = 1;
  for (std::size_t i = 0; i < entry.size(); ++i) {
    const std::size_t extent = entry.begin()[i];
    right = right && array.shape(i + 1) == extent;
    wanted += ", " + std::to_string(extent);
    stride *= extent;
  }
  if (!right) {
    for (std::size_t i = 0; i < array.ndim(); ++i) {
      given += (i ? ", " : "") + std::to_string(array.shape(i));
    }
    throw nb::value_error((std::string(name) + " must have shape (" + wanted +
                           "), one entry a body; its shape is (" + given + ")")
                              .c_str());
  }
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (std::isfinite(array.data()[i])) continue;
    throw nb::value_error(
        (std::string(name) + " of body " + std::to_string(i / stride) + " is not finite").c_str());
  }
}

std::vector<Pose> PosesOf(const Model& model, const NumbersIn& X_FB) {
  RequireBodies(X_FB, "X_FB", model.num_bodies(), {4, 4});
  std::vector<Pose> poses(model.num_bodies());
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = Pose::FromMatrix(X_FB.data() + 16 * i);
  return poses;
}

static_assert(sizeof(Twist) == 6 * sizeof(double));

std::span<const Twist> TwistsOf(const Model& model, const NumbersIn& V_FB) {
  RequireBodies(V_FB, "V_FB", model.num_bodies(), {6});
  return {reinterpret_cast<const Twist*>(V_FB.data()), V_FB.shape(0)};
}

FoundPointer Find(const Model& model, const NumbersIn& X_FB, const StepTable* table) {
  const std::vector<Pose> poses = PosesOf(model, X_FB);
  const nb::gil_scoped_release release;
  return model.Find(poses, table);
}

ForcesPointer ComputeForces(const Model& model, const FoundPointer& found, const NumbersIn& V_FB,
                            const StepTable* table) {
  const std::span<const Twist> twists = TwistsOf(model, V_FB);
  const nb::gil_scoped_release release;
  return model.ComputeForces(found, twists, table);
}

ForcesPointer Evaluate(const Model& model, const NumbersIn& X_FB, const NumbersIn& V_FB,
                       const StepTable* table) {
  const std::vector<Pose> poses = PosesOf(model, X_FB);
  const std::span<const Twist> twists = TwistsOf(model, V_FB);
  const nb::gil_scoped_release release;
  return model.ComputeForces(model.Find(poses, table), twists, table);
}

// Immutable objects are their own copies: a simulator may copy the values that hold them for free.
template <typename C>
void CopiesAreTheObject(C& bound) {
  bound.def("__copy__", [](nb::handle self) { return nb::borrow(self); });
  bound.def(
      "__deepcopy__", [](nb::handle self, nb::handle) { return nb::borrow(self); },
      nb::arg("memo"));
}

// One array over the loaded pairs.
template <typename T, typename Function>
auto PerPair(const Found& found, Function value) {
  std::vector<T> values(found.size);
  for (std::size_t i = 0; i < found.size; ++i) values[i] = static_cast<T>(value(found.loaded[i]));
  return ToNumpy<T>(std::move(values));
}

constexpr const char* kFoundDoc = R"(The loaded springs of all pairs at given poses; immutable.

Attributes
----------
pairs
    (m,) indices of the pairs in contact, ascending; the other arrays go with it.
num_springs
    (m,) loaded springs of each; their sum is the object's length.
num_probed
    (m,) facet pairs within the standoff (facet web), nodes looked at (area web).
status
    (m,) bits of `ContactStatus`.
p_FBo
    (nb, 3) where the origins of all bodies are [m].
)";

constexpr const char* kContactArraysDoc = R"(The loaded springs of a model, one row each; immutable.

In the common frame F of the model's bodies, which is W where a Drake system puts them out. A and B
are the geometries `model.pairs[pair].a` and `.b`. The force on A, applied at C, is
normal_force[:, None] * normal_F + friction_force_F, and B feels the opposite.

Attributes
----------
pair
    (n,) index into `ContactModel.pairs`, ascending.
key
    (n,) names the spring from step to step: two features (facet web), a node (area web).
p_FC
    (n, 3) point of application, midway between the witness points [m].
p_FCa, p_FCb
    (n, 3) witness points on A and B [m].
normal_F
    (n, 3) unit vectors from B towards A.
deformation, rate
    (n,) δ [m], and δ̇ [m/s], positive approaching. The area web integrates δ over the facets around
    its nodes, so that of a node at the rim of a contact may be a little below zero.
stiffness
    (n,) of the spring along its normal [N/m], at most.
normal_force
    (n,) on A along the normal [N]; negative only with adhesion.
friction_force_F
    (n, 3) on A [N].
multiplicity
    (n,) facet pairs behind the spring; 1 in the area web.
anchored
    (n,) whether the spring sticks, rather than slides.
status
    (n,) bits of `ContactStatus` of the pair.
)";

constexpr const char* kForcesDoc = R"(Forces of the springs found; immutable.

Attributes
----------
body_wrenches
    (nb, 6) on each body: torque about Bo [N m], then force [N], in F.
contacts
    `ContactArrays`, one row a loaded spring.
energies
    (2,) stored in normal and in tangential deformation [J].
stored
    Their sum [J].
powers
    (2,) being lost in damping and to friction [W].
power_given
    Given to the bodies [W]: their wrenches times their velocities.
V_FB
    (nb, 6) velocities of the bodies, as given.
found
    The springs they are of.
)";

constexpr const char* kStepTableDoc = R"(What lasts from one accepted step to the next; immutable.

Friction's anchors, which springs there were, and what has been lost.

Attributes
----------
time
    End of the step [s]; −infinity before the first.
losses
    (2,) lost in damping and to friction since the first step [J].
lost
    Their sum [J].
forces
    At the end of the step, as the next one starts with; None before the first.
)";

void BindFound(nb::module_& m) {
  auto found = nb::class_<Found>(m, "Found", kFoundDoc);
  CopiesAreTheObject(found);
  found.def("__len__", [](const Found& self) { return self.num_springs; })
      .def_prop_ro("pairs",
                   [](const Found& self) {
                     return PerPair<std::int32_t>(self,
                                                  [](const PairSprings& p) { return p.pair; });
                   })
      .def_prop_ro("num_springs",
                   [](const Found& self) {
                     return PerPair<std::int64_t>(
                         self, [](const PairSprings& p) { return p.springs.size(); });
                   })
      .def_prop_ro("num_probed",
                   [](const Found& self) {
                     return PerPair<std::int64_t>(
                         self, [](const PairSprings& p) { return p.springs.facet_pairs; });
                   })
      .def_prop_ro("status",
                   [](const Found& self) {
                     return PerPair<std::int32_t>(
                         self, [](const PairSprings& p) { return p.springs.status; });
                   })
      .def_prop_ro("p_FBo", [](const Found& self) {
        std::vector<Vec3> origins;
        for (const Pose& X_FB : self.X_FB) origins.push_back(X_FB.p);
        return ToNumpy(std::move(origins));
      });
}

template <typename E, auto member>
auto Column(nb::handle self) {
  const auto& values = nb::cast<const ContactArrays&>(self).*member;
  return ViewOf<E>(values, std::is_same_v<decltype(values), const std::vector<Vec3>&> ? 3 : 0,
                   self);
}

void BindContactArrays(nb::module_& m) {
  using C = ContactArrays;
  nb::class_<C>(m, "ContactArrays", kContactArraysDoc)
      .def("__len__", [](const C& self) { return self.pair.size(); })
      .def("__repr__",
           [](const C& self) {
             const std::set<std::int32_t> pairs(self.pair.begin(), self.pair.end());
             return "ContactArrays(" + std::to_string(self.pair.size()) + " springs of " +
                    std::to_string(pairs.size()) + " pairs)";
           })
      .def_prop_ro("pair", &Column<std::int32_t, &C::pair>)
      .def_prop_ro("key", &Column<std::uint64_t, &C::key>)
      .def_prop_ro("p_FC", &Column<double, &C::p_FC>)
      .def_prop_ro("p_FCa", &Column<double, &C::p_FCa>)
      .def_prop_ro("p_FCb", &Column<double, &C::p_FCb>)
      .def_prop_ro("normal_F", &Column<double, &C::normal_F>)
      .def_prop_ro("deformation", &Column<double, &C::deformation>)
      .def_prop_ro("rate", &Column<double, &C::rate>)
      .def_prop_ro("stiffness", &Column<double, &C::stiffness>)
      .def_prop_ro("normal_force", &Column<double, &C::normal_force>)
      .def_prop_ro("friction_force_F", &Column<double, &C::friction_force_F>)
      .def_prop_ro("multiplicity", &Column<std::int32_t, &C::multiplicity>)
      .def_prop_ro("anchored", &Column<bool, &C::anchored>)
      .def_prop_ro("status", &Column<std::int32_t, &C::status>);
}

void BindForces(nb::module_& m) {
  auto forces = nb::class_<Forces>(m, "Forces", kForcesDoc);
  CopiesAreTheObject(forces);
  forces
      .def_prop_ro("body_wrenches",
                   [](nb::handle self) {
                     return ViewOf<double>(nb::cast<const Forces&>(self).body_wrenches, 6, self);
                   })
      .def_prop_ro("found",
                   [](const Forces& self) { return std::const_pointer_cast<Found>(self.found); })
      .def_prop_ro("contacts", [](const Forces& self) { return ListContacts(self); })
      .def_prop_ro("energies",
                   [](const Forces& self) {
                     const Energetics& e = self.energetics;
                     return ToNumpy(std::vector<double>{e.stored_normal, e.stored_tangential});
                   })
      .def_prop_ro("powers",
                   [](const Forces& self) {
                     const Energetics& e = self.energetics;
                     return ToNumpy(std::vector<double>{e.damping_power, e.friction_power});
                   })
      .def_prop_ro("stored",
                   [](const Forces& self) {
                     const Energetics& e = self.energetics;
                     return e.stored_normal + e.stored_tangential;
                   })
      .def_prop_ro("power_given", &Forces::PowerGiven)
      .def_prop_ro("V_FB", [](nb::handle self) {
        return ViewOf<double>(nb::cast<const Forces&>(self).V_FB, 6, self);
      });
}

void BindStepTable(nb::module_& m) {
  auto table = nb::class_<StepTable>(m, "StepTable", kStepTableDoc);
  CopiesAreTheObject(table);
  table.def(nb::init<>())
      .def_ro("time", &StepTable::time)
      .def_prop_ro("losses",
                   [](const StepTable& self) {
                     return ToNumpy(std::vector<double>{self.damping_loss, self.friction_loss});
                   })
      .def_prop_ro("lost",
                   [](const StepTable& self) { return self.damping_loss + self.friction_loss; })
      .def_prop_ro(
          "forces",
          [](const StepTable& self) { return std::const_pointer_cast<Forces>(self.forces); },
          nb::sig("def forces(self) -> Forces | None"));
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
          [](ContactGeometry* self, std::shared_ptr<const CollisionMesh> mesh, int body,
             const PoseIn& X_BG) {
            new (self) ContactGeometry{std::move(mesh), body, Pose::FromMatrix(X_BG.data())};
          },
          nb::arg("mesh"), nb::arg("body"), nb::arg("X_BG"));
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
             bool adhesion, const Friction& friction) {
            new (self) ContactPair{a, b, std::move(web), {alpha, adhesion}, friction};
          },
          nb::arg("a"), nb::arg("b"), nb::arg("web"), nb::arg("alpha"), nb::arg("adhesion"),
          nb::arg("friction"));
  BindFound(m);
  BindContactArrays(m);
  BindForces(m);
  BindStepTable(m);
  nb::class_<Model>(m, "ContactModel")
      .def(nb::init<int, std::vector<ContactGeometry>, std::vector<ContactPair>, int>(),
           nb::arg("num_bodies"), nb::arg("geometries"), nb::arg("pairs"), nb::arg("threads"))
      .def("find", &Find, nb::arg("X_FB"), nb::arg("table").none() = nb::none())
      .def("forces", &ComputeForces, nb::arg("found"), nb::arg("V_FB"),
           nb::arg("table").none() = nb::none())
      .def("evaluate", &Evaluate, nb::arg("X_FB"), nb::arg("V_FB"),
           nb::arg("table").none() = nb::none())
      .def("coast", &Model::Coast, nb::arg("table"), nb::arg("duration"),
           nb::call_guard<nb::gil_scoped_release>())
      .def("advance", &Model::Advance, nb::arg("table"), nb::arg("time"), nb::arg("forces"),
           nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace contact_toolkit
