// FloatingBodies: multibody state to poses and velocities, wrenches to generalized forces.
#include "contact/floating_bodies.h"

#include <nanobind/stl/vector.h>

#include <stdexcept>
#include <string>

#include "bindings/arrays.h"

namespace contact_toolkit {
namespace {

FloatingBodies Make(const std::vector<int>& body, const std::vector<int>& q_start,
                    const std::vector<int>& v_start, const PosesIn& X_FB, int num_positions,
                    int num_velocities) {
  std::vector<FloatingBody> floating;
  for (std::size_t i = 0; i < body.size(); ++i) {
    floating.push_back({body[i], q_start.at(i), v_start.at(i)});
    const FloatingBody& added = floating.back();
    if (added.body < 0 || static_cast<std::size_t>(added.body) >= X_FB.shape(0) ||
        added.q_start < 0 || added.q_start + 7 > num_positions || added.v_start < 0 ||
        added.v_start + 6 > num_velocities) {
      throw nb::value_error(("floating body " + std::to_string(i) +
                             " lies outside the bodies, positions or velocities")
                                .c_str());
    }
  }
  return {
      std::move(floating), {X_FB.data(), X_FB.data() + X_FB.size()}, num_positions, num_velocities};
}

nb::typed<nb::tuple, Array<double>, Array<double>> Gather(const FloatingBodies& self,
                                                          const ArrayIn<double, Any>& state) {
  if (state.size() != static_cast<std::size_t>(self.num_states())) {
    throw nb::value_error(("state must hold " + std::to_string(self.num_states()) +
                           " numbers, not " + std::to_string(state.size()))
                              .c_str());
  }
  std::vector<double> X_FB, V_FB;
  self.Gather({state.data(), state.size()}, &X_FB, &V_FB);
  return nb::typed<nb::tuple, Array<double>, Array<double>>(
      nb::make_tuple(ToNumpy(std::move(X_FB)).attr("reshape")(self.num_bodies(), 4, 4),
                     ToNumpy(std::move(V_FB)).attr("reshape")(self.num_bodies(), 6)));
}

Array<double> Scatter(const FloatingBodies& self, const ArrayIn<double, Any, Extent<6>>& wrenches) {
  if (wrenches.shape(0) != self.num_bodies()) {
    throw nb::value_error(("body_wrenches must have " + std::to_string(self.num_bodies()) +
                           " rows, not " + std::to_string(wrenches.shape(0)))
                              .c_str());
  }
  return ToNumpy(self.Scatter({wrenches.data(), wrenches.size()}));
}

}  // namespace

void BindFloatingBodies(nb::module_& m) {
  nb::class_<FloatingBodies>(m, "FloatingBodies")
      .def(
          "__init__",
          [](FloatingBodies* self, const std::vector<int>& body, const std::vector<int>& q_start,
             const std::vector<int>& v_start, const PosesIn& X_FB, int num_positions,
             int num_velocities) {
            new (self)
                FloatingBodies(Make(body, q_start, v_start, X_FB, num_positions, num_velocities));
          },
          nb::arg("body"), nb::arg("q_start"), nb::arg("v_start"), nb::arg("X_FB"),
          nb::arg("num_positions"), nb::arg("num_velocities"))
      .def("gather", &Gather, nb::arg("state"))
      .def("scatter", &Scatter, nb::arg("body_wrenches"));
}

}  // namespace contact_toolkit
