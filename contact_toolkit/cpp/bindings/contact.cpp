// ContactModel and the immutable objects it hands out.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "bindings/arrays.h"
#include "bindings/immutable.h"
#include "contact/contact_arrays.h"
#include "contact/contact_model.h"
#include "contact/fields.h"
#include "web/facet_web.h"

namespace contact_toolkit {
namespace {

using NumbersIn = nb::ndarray<const double, nb::device::cpu, nb::c_contig>;
using Model = ContactModel;
using LoadedPointer = std::shared_ptr<const LoadedSprings>;
using ForcesPointer = std::shared_ptr<const Forces>;
using StatePointer = std::shared_ptr<const ContactState>;

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

// Up to what is left of the momentum balance when a step is solved: 1e-10 m/s, a millisecond long.
bool AreAlike(const Vec3& a, const Vec3& b, double tolerance) {
  return SquaredNorm(a - b) <= tolerance * tolerance * (1 + SquaredNorm(a));
}
bool AreAlike(const Pose& a, const Pose& b) {
  bool alike = AreAlike(a.p, b.p, 1e-12);
  for (int i = 0; i < 3; ++i) alike = alike && AreAlike(a.R.row[i], b.R.row[i], 1e-12);
  return alike;
}
bool AreAlike(const Twist& a, const Twist& b) {
  return AreAlike(a.w, b.w, 1e-8) && AreAlike(a.v, b.v, 1e-8);
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

// One array over the loaded pairs.
template <typename T, typename Function>
auto PerPair(const LoadedSprings& loaded, Function value) {
  std::vector<T> values(loaded.size);
  for (std::size_t i = 0; i < loaded.size; ++i) values[i] = static_cast<T>(value(loaded.pairs[i]));
  return ToNumpy<T>(std::move(values));
}

constexpr const char* kLoadedSpringsDoc =
    R"(The loaded springs of all pairs at given poses; immutable.

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
nominal
    Whether all of these are zero.
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

constexpr const char* kForcesDoc = R"(Forces of loaded springs; immutable.

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
    Given to the bodies [W]: their wrenches times their velocities.
V_FB
    (nb, 6) velocities of the bodies, as given.
loaded
    The springs they are of.
)";

constexpr const char* kLinearizationDoc =
    R"(How the forces of the loaded pairs change with poses and velocities; immutable.

Let body a carry a pair's geometry A, and body b its B. When a is displaced by a small rotation and a
translation of its origin, xi = (θ, t), and its twist relative to b (angular velocity, velocity of
a's origin) changes by dV, b being held, then the wrench on a about its origin (torque, force)
changes by dW = −(stiffness @ xi + damping @ dV). Everything is in F, rotations [rad] and torques
come first; the twist is held in F while a is displaced, and so are friction's anchors.

Attributes
----------
pair
    (m,) index into `ContactModel.pairs`, ascending; the other arrays go with it.
bodies
    (m, 2) indices of the bodies a and b.
wrench
    (m, 6) on a about its origin [N m], [N]; b feels the opposite at the same point.
stiffness
    (m, 6, 6) [N m/rad], [N m/m]; [N/rad], [N/m]. Not symmetric in general: sliding friction follows
    the normal force, and a loaded body that turns takes its load along.
damping
    (m, 6, 6) [N m s/rad], [N m s/m]; [N s/rad], [N s/m].
)";

constexpr const char* kContactStateDoc =
    R"(What lasts from one accepted step to the next; immutable.

Friction's anchors, which springs there were, and what has been lost.

Attributes
----------
time
    End of the step [s]; −infinity before the first.
losses
    (2,) lost in damping and to friction since the first step [J].
numerical_loss
    Lost to implicit steps, which take more energy than the law does [J].
lost
    Their sum [J].
forces
    At the end of the step, as the next one starts with; None before the first.
apart
    Pairs, ascending, whose boxes are in reach of each other and which are known to bear nothing:
    they are not searched until they may have come near.
)";

void BindLoadedSprings(nb::module_& m) {
  auto loaded = nb::class_<LoadedSprings>(m, "LoadedSprings", kLoadedSpringsDoc);
  CopiesAreTheObject(loaded);
  PicklesAs(loaded, "LoadedSprings");
  loaded.def("__len__", [](const LoadedSprings& self) { return self.num_springs; })
      .def_prop_ro("pairs",
                   [](const LoadedSprings& self) {
                     return PerPair<std::int32_t>(self,
                                                  [](const PairSprings& p) { return p.pair; });
                   })
      .def_prop_ro("num_springs",
                   [](const LoadedSprings& self) {
                     return PerPair<std::int64_t>(
                         self, [](const PairSprings& p) { return p.springs.size(); });
                   })
      .def_prop_ro("num_probed",
                   [](const LoadedSprings& self) {
                     return PerPair<std::int64_t>(
                         self, [](const PairSprings& p) { return p.springs.num_measured; });
                   })
      .def_prop_ro("nominal",
                   [](const LoadedSprings& self) {
                     return std::all_of(
                         self.pairs.begin(), self.pairs.begin() + self.size,
                         [](const PairSprings& p) { return p.springs.status == kNominal; });
                   })
      .def_prop_ro("status",
                   [](const LoadedSprings& self) {
                     return PerPair<std::int32_t>(
                         self, [](const PairSprings& p) { return p.springs.status; });
                   })
      .def_prop_ro("p_FBo", [](const LoadedSprings& self) {
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
  auto arrays = nb::class_<C>(m, "ContactArrays", kContactArraysDoc);
  CopiesAreTheObject(arrays);
  PicklesAs(arrays, "ContactArrays");
  arrays.def("__len__", [](const C& self) { return self.pair.size(); })
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
  PicklesAs(forces, "Forces");
  forces
      .def_prop_ro("body_wrenches",
                   [](nb::handle self) {
                     return ViewOf<double>(nb::cast<const Forces&>(self).body_wrenches, 6, self);
                   })
      .def_prop_ro(
          "loaded",
          [](const Forces& self) { return std::const_pointer_cast<LoadedSprings>(self.loaded); })
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
      .def_prop_ro("power_given", [](const Forces& self) { return self.PowerAt(self.V_FB); })
      .def(
          "are_at",
          [](const Forces& self, const NumbersIn& X_FB, const NumbersIn& V_FB) {
            const int bodies = static_cast<int>(self.V_FB.size());
            RequireBodies(X_FB, "X_FB", bodies, {4, 4});
            RequireBodies(V_FB, "V_FB", bodies, {6});
            const auto* twists = reinterpret_cast<const Twist*>(V_FB.data());
            for (int i = 0; i < bodies; ++i) {
              const Pose pose = Pose::FromMatrix(X_FB.data() + 16 * i);
              if (!AreAlike(self.loaded->X_FB[i], pose) || !AreAlike(self.V_FB[i], twists[i])) {
                return false;
              }
            }
            return true;
          },
          nb::arg("X_FB"), nb::arg("V_FB"),
          "Whether they were computed at these poses and velocities, up to rounding.")
      .def_prop_ro("V_FB", [](nb::handle self) {
        return ViewOf<double>(nb::cast<const Forces&>(self).V_FB, 6, self);
      });
}

Array<double> ViewOfMatrices(const std::vector<Mat6>& values, nb::handle owner) {
  const std::size_t shape[3] = {values.size(), 6, 6};
  const auto* data = reinterpret_cast<const double*>(values.data());
  return Array<double>(nb::cast(nb::ndarray<nb::numpy, nb::ro, double>(data, 3, shape, owner)));
}

void BindLinearization(nb::module_& m) {
  using L = Linearization;
  static_assert(sizeof(Mat6) == 36 * sizeof(double));
  auto linearization = nb::class_<L>(m, "Linearization", kLinearizationDoc);
  CopiesAreTheObject(linearization);
  linearization.def("__len__", [](const L& self) { return self.pair.size(); })
      .def_prop_ro("pair",
                   [](nb::handle self) {
                     return ViewOf<std::int32_t>(nb::cast<const L&>(self).pair, 0, self);
                   })
      .def_prop_ro("bodies",
                   [](nb::handle self) {
                     return ViewOf<std::int32_t>(nb::cast<const L&>(self).bodies, 2, self);
                   })
      .def_prop_ro(
          "wrench",
          [](nb::handle self) { return ViewOf<double>(nb::cast<const L&>(self).wrench, 6, self); })
      .def_prop_ro(
          "stiffness",
          [](nb::handle self) { return ViewOfMatrices(nb::cast<const L&>(self).stiffness, self); })
      .def_prop_ro("damping", [](nb::handle self) {
        return ViewOfMatrices(nb::cast<const L&>(self).damping, self);
      });
}

void BindContactState(nb::module_& m) {
  auto state = nb::class_<ContactState>(m, "ContactState", kContactStateDoc);
  CopiesAreTheObject(state);
  PicklesAs(state, "ContactState", [](ContactState* loaded) {
    if (loaded->model_id != 0) loaded->id = NewStateId();
  });
  state.def(nb::init<>())
      .def_ro("time", &ContactState::time)
      .def_prop_ro("losses",
                   [](const ContactState& self) {
                     return ToNumpy(std::vector<double>{self.damping_loss, self.friction_loss});
                   })
      .def_ro("numerical_loss", &ContactState::numerical_loss)
      .def_prop_ro("lost",
                   [](const ContactState& self) { return self.damping_loss + self.friction_loss; })
      .def_prop_ro(
          "forces",
          [](const ContactState& self) { return std::const_pointer_cast<Forces>(self.forces); },
          nb::sig("def forces(self) -> Forces | None"))
      .def_prop_ro("apart", [](const ContactState& self) {
        std::vector<std::int32_t> pairs;
        for (const Separation& apart : self.separations) pairs.push_back(apart.pair);
        return ToNumpy<std::int32_t>(std::move(pairs));
      });
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
  BindLoadedSprings(m);
  BindContactArrays(m);
  BindForces(m);
  BindLinearization(m);
  BindContactState(m);
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
