// The balance of momentum over a step: its residual at given velocities, and Newton's matrix there.
#pragma once

#include <span>
#include <vector>

#include "contact/contact_model.h"
#include "step/block_matrix.h"
#include "step/body_kinematics.h"
#include "step/step_problem.h"

namespace contact_toolkit {

// Trees that contacts join, to be solved together.
struct StepIsland {
  std::vector<int> trees, works, bodies;
};

// Whether to find what Newton's matrix needs along with the forces.
enum class Slopes { kLeftOut, kFound };

// A pair that may touch, and what it does at the velocities last evaluated.
struct StepWork {
  PairSprings found;
  std::vector<Stretch> stretches;
  std::vector<SpringForce> springs;
  PairForce total;
  bool tried = false;  // `found` is of an earlier trial
};

// The spatial inertia of a floating tree about Ro, in F.
Mat6 InertiaInF(const StepTopology& topology, int index, std::span<const double> q0);

// Of one step. Trees and bodies that nothing comes near never appear. Sizes of momenta are in the
// metric of A⁻¹.
class StepEquations {
 public:
  // All of them outlive it.
  StepEquations(const ContactModel& model, const StepTopology& topology, const StepProblem& problem,
                const ContactState& state);

  // Takes up the pairs that are near at the end of a step at velocities `v`, or at `also_v`;
  // whether there was a new one. Bodies then stand where `v` leads.
  bool AddPairs(std::span<const double> v);
  bool AddPairs(std::span<const double> v, std::span<const double> also_v);

  // The islands of the pairs taken up, by their first trees.
  std::vector<StepIsland> MakeIslands();

  // Whether one of its pairs touched in the last step.
  bool WasInContact(const StepIsland& island) const;

  // |A (v_free − v0)|: what the step does without contact.
  double FreeChange(const StepIsland& island) const;

  // |A v_free|², as residuals are measured: what a stand would leave without contact.
  double FreeEnergy(const StepIsland& island) const;

  // Sets poses and forces at velocities `v`, of these islands.
  void Evaluate(const std::vector<const StepIsland*>& islands, std::span<const double> v,
                Slopes slopes);

  // Sets the residual r = A (v − v_free) − h f with the forces last evaluated; returns |r|².
  double SetResidual(const StepIsland& island, std::span<const double> v);

  // What contact does, to measure the residual by: its impulse; a share of what the springs would
  // do if they all pushed one way, as in a wedge they push against each other and their rounding is
  // all that moves it; and a speed that counts as none.
  double ContactChange(const StepIsland& island);

  // dr/dv where forces were last evaluated, with slopes, at `v`: A less h times the derivative of
  // the generalized forces, by poses and velocities alike. Without Symmetry::kNone what turns along
  // with the bodies, the wrenches and their arms, counts as fixed. A block per tree.
  void Assemble(const StepIsland& island, std::span<const double> v, Symmetry symmetry,
                BlockMatrix* matrix) const;

  std::vector<StepWork>& works() { return works_; }  // by ascending pair
  std::span<const double> residual() const { return residual_; }
  const std::vector<double>& forces() const { return f_; }  // generalized
  const std::vector<Pose>& X_FB() const { return X_FB_; }
  const std::vector<Twist>& V_FB() const { return V_FB_; }

 private:
  struct Tree {
    int block = -1;               // within its island
    std::vector<double> inertia;  // A, (nv, nv)
    std::vector<double> factor;   // its Cholesky factor; empty: nothing that contact could push
  };

  int TreeOf(int geometry) const {
    return topology_.bodies[model_.geometries()[geometry].body].tree;
  }
  void Place(int body, std::span<const double> v);
  std::vector<int> PairsAt(std::span<const double> v);
  bool TakeUp(const std::vector<int>& pairs);
  void SetInertia(int tree);
  void AddUpForces(const StepIsland& island);
  void Push(int body, const Vec3& p_FP, const Vec3& torque, const Vec3& force, double* f) const;
  double SizeOf(int tree, const double* momentum) const;
  // vᵀ A v of an island, for the velocity of each degree of freedom.
  double SquaredSizeOf(const StepIsland& island, const auto& velocity) const;
  double LightnessOf(int body);
  void AddPair(const StepWork& work, std::span<const double> v, Symmetry symmetry,
               BlockMatrix* matrix) const;

  const ContactModel& model_;
  const StepTopology& topology_;
  const StepProblem& problem_;
  const ContactState& state_;
  BodyKinematics kinematics_;
  std::vector<double> f_, residual_;
  std::vector<Tree> trees_;
  std::vector<Pose> X_FB_;
  std::vector<Twist> V_FB_;
  std::vector<double> squeeze_;    // [N] per body, all that its springs push with
  std::vector<double> lightness_;  // per body; negative: not asked yet
  std::vector<StepWork> works_;
};

}  // namespace contact_toolkit
