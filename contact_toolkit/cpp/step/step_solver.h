// Solves a step for the velocities at its end: Newton's method on the balance of momentum, island
// by island, with a line search on the residual in the metric of the inverse inertia.
#pragma once

#include <memory>

#include "contact/contact_model.h"
#include "step/step_problem.h"

namespace contact_toolkit {

// Immutable; shared between threads freely; the same bits on any number of threads.
class StepSolver {
 public:
  StepSolver(std::shared_ptr<const ContactModel> model, StepTopology topology);

  const StepTopology& topology() const { return topology_; }
  const ContactModel& model() const { return *model_; }

  // Velocities at the end of a step under gravity alone, with the inertia and gyroscopic forces of
  // its start; of floating trees, others keep theirs.
  std::vector<double> FreeMotion(std::span<const double> q0, std::span<const double> v0,
                                 double step, const Vec3& gravity) const;

  // `state`: of the contact at the start of the step.
  StepSolution Solve(const StepProblem& problem, const ContactState& state) const;

 private:
  class Search;

  std::shared_ptr<const ContactModel> model_;
  StepTopology topology_;
};

}  // namespace contact_toolkit
