// StepSolver: steps of a discrete multibody system solved implicitly in its contact forces.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "bindings/arrays.h"
#include "bindings/immutable.h"
#include "contact/fields.h"
#include "step/free_motion.h"
#include "step/step_solver.h"

namespace contact_toolkit {
namespace {

using Numbers = ArrayIn<double, Any>;

constexpr const char* kSolutionDoc = R"(One step, solved; immutable.

Attributes
----------
start_time, end_time
    Of the step [s].
v
    (nv,) velocities reached, as far as the solver sees the system.
generalized_forces
    (nv,) of contact, to act over the whole step. They include what the solver left of the momentum
    balance, so that the step ends at v; all but nothing where it converged.
forces
    `Forces` at its end.
status
    0: converged; 1: as far as the arithmetic goes; 2: iteration limit, the best found.
islands, iterations, evaluations
    Groups of bodies that contact couples; Newton iterations of the slowest; evaluations of the
    contact forces.
residual
    Of the momentum balance, relative to what drives the step.
)";

void Require(bool right, const std::string& message) {
  if (!right) throw nb::value_error(message.c_str());
}

void RequireFinite(const double* values, std::size_t size, const char* name) {
  for (std::size_t i = 0; i < size; ++i) {
    if (std::isfinite(values[i])) continue;
    Require(false,
            std::string(name) + " holds " + std::to_string(values[i]) + " at " + std::to_string(i));
  }
}

std::span<const double> Vector(const Numbers& array, std::size_t size, const char* name) {
  if (array.shape(0) != size) {
    Require(false, std::string(name) + " must hold " + std::to_string(size) + " numbers, not " +
                       std::to_string(array.shape(0)));
  }
  RequireFinite(array.data(), size, name);
  return {array.data(), size};
}

StepTopology MakeTopology(int num_positions, int num_velocities, const std::vector<int>& v_start,
                          const std::vector<int>& nv, const std::vector<int>& q_start,
                          const ArrayIn<double, Any, Extent<6>, Extent<6>>& inertia_R,
                          const std::vector<int>& tree, const PosesIn& X_RB) {
  StepTopology topology{num_positions, num_velocities, {}, {}, {}};
  Require(v_start.size() == nv.size() && v_start.size() == q_start.size() &&
              v_start.size() == inertia_R.shape(0),
          "v_start, nv, q_start and inertia_R must have one entry a tree");
  int end = 0;
  for (std::size_t i = 0; i < nv.size(); ++i) {
    const bool floats = q_start[i] >= 0;
    Require(
        v_start[i] >= end && nv[i] > 0 && v_start[i] + nv[i] <= num_velocities &&
            (!floats || (nv[i] == 6 && q_start[i] + 7 <= num_positions)),
        "tree " + std::to_string(i) + " lies outside the positions or velocities, or upon another");
    end = v_start[i] + nv[i];
    topology.trees.push_back({v_start[i], nv[i], q_start[i]});
  }
  topology.inertia_R.assign(inertia_R.data(), inertia_R.data() + inertia_R.size());
  Require(tree.size() == X_RB.shape(0), "tree and X_RB must have one entry a body");
  for (std::size_t i = 0; i < tree.size(); ++i) {
    Require(tree[i] >= -1 && tree[i] < static_cast<int>(nv.size()),
            "body " + std::to_string(i) + " is of tree " + std::to_string(tree[i]) +
                "; there are " + std::to_string(nv.size()));
    topology.bodies.push_back({tree[i], Pose::FromMatrix(X_RB.data() + 16 * i)});
  }
  return topology;
}

void RequireStateOf(const StepSolver& solver, const ContactState& state) {
  if (state.model_id != 0 && state.model_id != solver.model().id()) {
    throw nb::value_error(
        "state must come from the solver's ContactModel or an equal one, and comes from another");
  }
}

// What every solve is given.
struct Inputs {
  StepProblem problem;
  std::vector<Pose> poses;
};

void SetInputs(const StepSolver& self, double time, double step, const Numbers& q0,
               const Numbers& v0, const PosesIn& X_FB, Inputs* inputs) {
  const StepTopology& topology = self.topology();
  Require(std::isfinite(time) && step > 0, "step must be a time [s] > 0, and time finite");
  Require(X_FB.shape(0) == topology.bodies.size(), "X_FB must have one pose a body");
  RequireFinite(X_FB.data(), X_FB.size(), "X_FB");
  inputs->poses.reserve(topology.bodies.size());
  for (std::size_t i = 0; i < topology.bodies.size(); ++i) {
    inputs->poses.push_back(Pose::FromMatrix(X_FB.data() + 16 * i));
  }
  StepProblem& problem = inputs->problem;
  problem.time = time;
  problem.step = step;
  problem.q0 = Vector(q0, topology.num_positions, "q0");
  problem.v0 = Vector(v0, topology.num_velocities, "v0");
  problem.X_FB = inputs->poses;
}

bool HasJoints(const StepTopology& topology) {
  return std::ranges::any_of(topology.trees, [](const StepTree& tree) { return tree.q_start < 0; });
}

std::shared_ptr<const StepSolution> SolveAndShare(const StepSolver& self, const Inputs& inputs,
                                                  const ContactState& state) {
  return std::make_shared<const StepSolution>(self.Solve(inputs.problem, state));
}

std::shared_ptr<const StepSolution> Solve(const StepSolver& self, const ContactState& state,
                                          double time, double step, const Numbers& q0,
                                          const Numbers& v0, const Numbers& v_free,
                                          const PosesIn& X_FB,
                                          const ArrayIn<double, Any, Any>& inertia,
                                          const ArrayIn<double, Any, Extent<6>, Any>& jacobian,
                                          const Numbers& v_reference) {
  RequireStateOf(self, state);
  const StepTopology& topology = self.topology();
  const std::size_t nv = topology.num_velocities, bodies = topology.bodies.size();
  Inputs inputs;
  SetInputs(self, time, step, q0, v0, X_FB, &inputs);
  StepProblem& problem = inputs.problem;
  problem.v_free = Vector(v_free, nv, "v_free");
  problem.v_reference = Vector(v_reference, nv, "v_reference");
  if (HasJoints(topology)) {
    Require(inertia.shape(0) == nv && inertia.shape(1) == nv, "inertia must be (nv, nv)");
    Require(jacobian.shape(0) == bodies && jacobian.shape(2) == nv, "jacobian must be (nb, 6, nv)");
    RequireFinite(inertia.data(), inertia.size(), "inertia");
    RequireFinite(jacobian.data(), jacobian.size(), "jacobian");
    problem.inertia = {inertia.data(), inertia.size()};
    problem.jacobian = {jacobian.data(), jacobian.size()};
  }
  const nb::gil_scoped_release release;
  return SolveAndShare(self, inputs, state);
}

std::shared_ptr<const StepSolution> SolveUnderGravity(
    const StepSolver& self, const ContactState& state, double time, double step, const Numbers& q0,
    const Numbers& v0, const ArrayIn<double, Extent<3>>& gravity, const PosesIn& X_FB) {
  RequireStateOf(self, state);
  Require(!HasJoints(self.topology()), "what moves under gravity alone has no joints");
  Inputs inputs;
  SetInputs(self, time, step, q0, v0, X_FB, &inputs);
  StepProblem& problem = inputs.problem;
  const nb::gil_scoped_release release;
  const std::vector<double> v_free = FreeMotion(self.topology(), problem.q0, problem.v0, step,
                                                {gravity(0), gravity(1), gravity(2)});
  problem.v_free = v_free;
  problem.v_reference = problem.v0;
  return SolveAndShare(self, inputs, state);
}

}  // namespace

void BindStep(nb::module_& m) {
  using S = StepSolution;
  auto solution = nb::class_<S>(m, "StepSolution", kSolutionDoc);
  CopiesAreTheObject(solution);
  PicklesAs(solution, "StepSolution");
  solution.def_ro("start_time", &S::start_time)
      .def_ro("end_time", &S::end_time)
      .def_prop_ro(
          "v", [](nb::handle self) { return ViewOf<double>(nb::cast<const S&>(self).v, 0, self); })
      .def_prop_ro("generalized_forces",
                   [](nb::handle self) {
                     return ViewOf<double>(nb::cast<const S&>(self).generalized_forces, 0, self);
                   })
      .def_prop_ro("forces",
                   [](const S& self) { return std::const_pointer_cast<Forces>(self.forces); })
      .def_prop_ro("status", [](const S& self) { return static_cast<int>(self.status); })
      .def_ro("islands", &S::islands)
      .def_ro("iterations", &S::iterations)
      .def_ro("evaluations", &S::evaluations)
      .def_ro("residual", &S::residual);
  nb::class_<StepSolver>(m, "StepSolver")
      .def(
          "__init__",
          [](StepSolver* self, std::shared_ptr<const ContactModel> model, int num_positions,
             int num_velocities, const std::vector<int>& v_start, const std::vector<int>& nv,
             const std::vector<int>& q_start,
             const ArrayIn<double, Any, Extent<6>, Extent<6>>& inertia_R,
             const std::vector<int>& tree, const PosesIn& X_RB) {
            StepTopology topology = MakeTopology(num_positions, num_velocities, v_start, nv,
                                                 q_start, inertia_R, tree, X_RB);
            Require(static_cast<int>(topology.bodies.size()) == model->num_bodies(),
                    "tree must have one entry a body of the model");
            new (self) StepSolver(std::move(model), std::move(topology));
          },
          nb::arg("model"), nb::arg("num_positions"), nb::arg("num_velocities"), nb::arg("v_start"),
          nb::arg("nv"), nb::arg("q_start"), nb::arg("inertia_R"), nb::arg("tree"), nb::arg("X_RB"))
      .def(
          "free_motion",
          [](const StepSolver& self, const Numbers& q0, const Numbers& v0, double step,
             const ArrayIn<double, Extent<3>>& gravity) {
            const StepTopology& topology = self.topology();
            return ToNumpy(FreeMotion(topology, Vector(q0, topology.num_positions, "q0"),
                                      Vector(v0, topology.num_velocities, "v0"), step,
                                      {gravity(0), gravity(1), gravity(2)}));
          },
          nb::arg("q0"), nb::arg("v0"), nb::arg("step"), nb::arg("gravity"))
      .def("solve", &Solve, nb::arg("state"), nb::arg("time"), nb::arg("step"), nb::arg("q0"),
           nb::arg("v0"), nb::arg("v_free"), nb::arg("X_FB"), nb::arg("inertia"),
           nb::arg("jacobian"), nb::arg("v_reference"))
      .def("solve_under_gravity", &SolveUnderGravity, nb::arg("state"), nb::arg("time"),
           nb::arg("step"), nb::arg("q0"), nb::arg("v0"), nb::arg("gravity"), nb::arg("X_FB"));
}

}  // namespace contact_toolkit
