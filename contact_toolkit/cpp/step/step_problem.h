// One step of a discrete multibody system under contact, as the solver sees it: backward Euler in
// all contact forces,
//   A (v⁺ − v_free) = h Σ Jᵀ F(q⁺, v⁺),   q⁺ = q₀ + h N v⁺,
// where v_free is the velocity the system would reach without contact and A = h (∂v⁺/∂f)⁻¹ the
// inertia with which it answers generalized forces: the mass matrix, and what the system itself
// takes implicitly (joint damping, controller gains).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "base/archive.h"
#include "contact/contact_state.h"
#include "contact/forces.h"
#include "math/relative_motion.h"
#include "math/vec.h"

namespace contact_toolkit {

// Degrees of freedom that a block of A couples with each other only.
struct StepTree {
  int v_start = 0, nv = 0;
  // Of a tree that is a single rigid body on a quaternion joint: where it stands in q (quaternion
  // [w x y z], position); its velocities are angular then translational, in F. −1: another tree.
  int q_start = -1;
};

// How a body of the contact model moves.
struct StepBody {
  int tree = -1;  // −1: it does not
  Pose X_RB;      // of a floating tree: in the frame R of the body that floats
};

struct StepTopology {
  int num_positions = 0, num_velocities = 0;
  std::vector<StepTree> trees;
  std::vector<StepBody> bodies;  // of the contact model
  // [36 a floating tree] spatial inertia about Ro in R, rotation first; zeros for other trees.
  std::vector<double> inertia_R;
};

// Arrays are the caller's; what only non-floating trees need may be empty without them.
struct StepProblem {
  double time = 0, step = 0;            // [s] the step ends at time + step
  std::span<const double> q0, v0;       // at the start
  std::span<const double> v_free;       // at the end, without contact
  std::span<const double> inertia;      // A, (nv, nv); read on the blocks of non-floating trees
  std::span<const Pose> X_FB;           // of every body at the start, or of those of non-floating
                                        // trees at `v_reference`'s end
  std::span<const double> jacobian;     // (nb, 6, nv) dV_FB/dv there, rotation first
  std::span<const double> v_reference;  // likely to be reached; they lead to X_FB over the step
};

enum class StepStatus {
  kConverged,
  kRoundOff,        // no step improves: converged as far as the arithmetic goes
  kIterationLimit,  // the best found is returned
};

struct StepSolution {
  double start_time = 0, end_time = 0;     // [s]
  std::vector<double> v;                   // reached, (nv)
  std::vector<double> generalized_forces;  // A (v − v_free) / h: Σ Jᵀ F and what is left over, (nv)
  std::shared_ptr<const Forces> forces;    // at the end of the step
  StepStatus status = StepStatus::kConverged;  // the worst of the islands
  int islands = 0;                             // groups of trees that contact couples
  int iterations = 0;                          // Newton iterations of the slowest island
  int evaluations = 0;                         // of the contact forces
  double residual = 0;                         // largest over islands, relative to what drives them
};

auto Fields(Of<StepSolution> auto& self) {
  return std::tie(self.start_time, self.end_time, self.v, self.generalized_forces, self.forces,
                  self.status, self.islands, self.iterations, self.evaluations, self.residual);
}

}  // namespace contact_toolkit
