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

  // `state`: of the contact at the start of the step.
  StepSolution Solve(const StepProblem& problem, const ContactState& state) const;

 private:
  class Search;

  std::shared_ptr<const ContactModel> model_;
  StepTopology topology_;
};

}  // namespace contact_toolkit
