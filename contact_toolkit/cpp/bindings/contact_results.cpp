// The immutable objects that a ContactModel hands out.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "bindings/body_arrays.h"
#include "bindings/immutable.h"
#include "contact/contact_arrays.h"
#include "contact/contact_state.h"
#include "contact/fields.h"
#include "contact/linearization.h"

namespace contact_toolkit {
namespace {

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
power_given
    To the bodies [W]: their wrenches times their velocities.
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
            std::vector<Pose> poses(bodies);
            for (int i = 0; i < bodies; ++i) poses[i] = Pose::FromMatrix(X_FB.data() + 16 * i);
            const auto* twists = reinterpret_cast<const Twist*>(V_FB.data());
            return self.AreAt(poses, {twists, poses.size()});
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

void BindContactResults(nb::module_& m) {
  BindLoadedSprings(m);
  BindContactArrays(m);
  BindForces(m);
  BindLinearization(m);
  BindContactState(m);
}

}  // namespace contact_toolkit
