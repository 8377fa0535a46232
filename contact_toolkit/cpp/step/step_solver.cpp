#include "step/step_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "base/tolerances.h"
#include "contact/pair_linearization.h"
#include "step/block_matrix.h"
#include "step/step_equations.h"
#include "step/step_path.h"

namespace contact_toolkit {
namespace {

double Square(double x) { return x * x; }

}  // namespace

// One solve.
class StepSolver::Search {
 public:
  Search(const StepSolver& solver, const StepProblem& problem, const ContactState& state)
      : model_(*solver.model_),
        topology_(solver.topology_),
        problem_(problem),
        state_(state),
        equations_(model_, topology_, problem, state),
        v_(problem.v_free.begin(), problem.v_free.end()),
        trial_(v_),
        direction_(v_.size(), 0.0) {
    solution_.start_time = problem.time;
    solution_.end_time = problem.time + problem.step;
  }

  StepSolution Run() {
    equations_.AddPairs(v_, problem_.v0);
    for (int round = 0; round < kStepRounds && !equations_.works().empty(); ++round) {
      Start(round == 0);
      SolveIslands();
      // What the bodies have come near to on the way.
      if (!equations_.AddPairs(v_)) break;
    }
    Finish();
    return std::move(solution_);
  }

 private:
  enum class Phase { kDone, kSearching };

  struct Island {
    StepIsland joined;
    Phase phase = Phase::kSearching;
    StepStatus status = StepStatus::kConverged;
    double merit = 0;          // |r|²
    double drive = 0;          // what the step does without contact
    double length = 1;         // of the present trial, as a share of the Newton step
    bool symmetric = false;    // take the symmetric part of Newton's matrix
    bool stuck = false;        // neither matrix led any further
    bool from_last = false;    // began at the velocities of the last step
    bool still = false;        // moved so slowly in the last step that it began at none
    bool at_rest = false;      // and as slowly as a body at rest
    std::vector<double> best;  // velocities of the best start so far
    double best_merit = 0;
    int iterations = 0;
    BlockMatrix matrix;
  };

  // Does `act` to the place of each of the island's velocities.
  template <typename Act>
  void ForEachDof(const Island& island, Act act) const {
    for (const int index : island.joined.trees) {
      const StepTree& tree = topology_.trees[index];
      for (int dof = tree.v_start; dof < tree.v_start + tree.nv; ++dof) act(dof);
    }
  }

  // Each starts from the reference where it was in contact in the last step, else from the
  // velocities without contact. What hardly moved starts from a stand: the springs of a body at
  // rest are so stiff that to go on for a step at the speed that it came to rest with overshoots.
  void Start(bool first) {
    islands_.clear();
    for (StepIsland& joined : equations_.MakeIslands()) {
      Island& island = islands_.emplace_back();
      island.from_last = first && equations_.WasInContact(joined);
      island.drive = equations_.FreeChange(joined);
      island.joined = std::move(joined);
      if (!island.from_last) continue;
      double speed = 0;
      ForEachDof(island, [&](int dof) {
        v_[dof] = problem_.v_reference[dof];
        speed = std::max(speed, std::abs(problem_.v0[dof]));
      });
      island.still = speed < kStepStill;
      island.at_rest = speed < kStepAtRest;
      if (island.still) ForEachDof(island, [&](int dof) { v_[dof] = 0; });
    }
  }

  // Where Newton's method fails, it goes on from where paths lead: a wedge that lets go has no
  // solution near the one at rest.
  void SolveIslands() {
    Iterate();
    if (std::ranges::none_of(islands_, Failed)) return;
    for (const double start : kPathStarts) {
      for (Island& island : islands_) {
        if (Failed(island)) Lead(&island, start);
      }
      Iterate();
    }
    for (Island& island : islands_) {
      if (!Failed(island)) continue;
      KeepBest(&island);
      island.phase = Phase::kSearching;
    }
    EvaluateAtAccepted();
    for (Island& island : islands_) island.phase = Phase::kDone;
  }

  static bool Failed(const Island& island) { return island.status == StepStatus::kIterationLimit; }

  // Goes to the best velocities that a search has ended with so far.
  void KeepBest(Island* island) {
    if (island->best.empty() || island->merit < island->best_merit) {
      island->best = v_;
      island->best_merit = island->merit;
    }
    ForEachDof(*island, [&](int dof) { v_[dof] = island->best[dof]; });
  }

  // To the end of a path that starts at this share of the velocities without contact, if it has
  // one.
  void Lead(Island* island, double start) {
    KeepBest(island);
    std::vector<double> v = v_;
    ForEachDof(*island, [&](int dof) { v[dof] = start * problem_.v_free[dof]; });
    StepPath path(&equations_, island->joined);
    const bool arrived = path.Follow(v);
    solution_.evaluations += path.evaluations();
    if (!arrived) return;
    v_ = v;
    island->phase = Phase::kSearching;
    island->status = StepStatus::kConverged;
    island->symmetric = island->stuck = false;
  }

  // Bodies that fly at each other are deep in each other at the end of a step, where forces no
  // longer tell the way out. So where the start is worse than a stand without any contact would be,
  // it is approached from a stand, as far as that is good.
  void ApproachStarts() {
    std::vector<Island*> flying, others;
    for (Island& island : islands_) {
      if (island.phase != Phase::kSearching) continue;
      const bool bad = !island.still && island.merit > equations_.FreeEnergy(island.joined);
      (bad ? flying : others).push_back(&island);
    }
    if (flying.empty()) return;
    for (Island* island : others) island->phase = Phase::kDone;
    std::vector<double> merits;
    for (Island* island : flying) {
      merits.push_back(island->merit);
      ForEachDof(*island, [&](int dof) { direction_[dof] = std::exchange(v_[dof], 0.0); });
      island->length = 0.5;
    }
    EvaluateAtAccepted();
    for (std::size_t i = 0; i < flying.size(); ++i) {
      if (flying[i]->merit < merits[i]) continue;
      ForEachDof(*flying[i], [&](int dof) { v_[dof] = direction_[dof]; });
      flying[i]->length = 0;  // no search: only its forces are wanted again
    }
    LineSearch();
    for (Island* island : flying)
      island->symmetric = false;  // nothing is known of Newton's way yet
    for (Island* island : others) island->phase = Phase::kSearching;
  }

  // Newton's method, for the islands that are searching.
  void Iterate() {
    // What is at rest mostly stays at rest, and needs no slopes.
    bool linear = !std::ranges::all_of(
        islands_, [](const Island& i) { return i.at_rest || i.phase == Phase::kDone; });
    EvaluateAtAccepted(linear ? Slopes::kFound : Slopes::kLeftOut);
    ApproachStarts();
    for (int iteration = 0; iteration < kStepIterations; ++iteration) {
      for (Island& island : islands_) {
        if (island.phase == Phase::kSearching && Converged(island)) island.phase = Phase::kDone;
      }
      if (!AnySearching()) return;
      if (!std::exchange(linear, true)) EvaluateAtAccepted();
      LookAhead();
      ParallelFor(static_cast<int>(islands_.size()), model_.threads(), [&](int i, int) {
        if (islands_[i].phase == Phase::kSearching) FindDirection(&islands_[i]);
      });
      linear = !IsLastStep();
      LineSearch(linear ? Slopes::kFound : Slopes::kLeftOut);
    }
    for (Island& island : islands_) {
      if (island.phase != Phase::kSearching) continue;
      island.status = StepStatus::kIterationLimit;
      island.phase = Phase::kDone;
    }
  }

  bool AnySearching() const {
    return std::ranges::any_of(islands_,
                               [](const Island& i) { return i.phase == Phase::kSearching; });
  }

  // Whether all is so close to being solved that the next step is likely to do.
  bool IsLastStep() {
    return std::ranges::all_of(islands_, [this](const Island& island) {
      return island.phase == Phase::kDone || island.merit <= Square(kStepNear * ScaleOf(island));
    });
  }

  // Forces at the trial velocities, of the islands that are searching.
  void Evaluate(Slopes slopes = Slopes::kFound) {
    std::vector<const StepIsland*> searching;
    for (const Island& island : islands_) {
      if (island.phase == Phase::kSearching) searching.push_back(&island.joined);
    }
    equations_.Evaluate(searching, trial_, slopes);
    ++solution_.evaluations;
  }

  void EvaluateAtAccepted(Slopes slopes = Slopes::kFound) {
    trial_ = v_;
    Evaluate(slopes);
    for (Island& island : islands_) {
      if (island.phase == Phase::kSearching) {
        island.merit = equations_.SetResidual(island.joined, v_);
      }
    }
  }

  // Where no way along the last direction was good, contacts that it makes stand in the way: bodies
  // that just touch. So that the next one knows them, they are linearized a little along it; the
  // residual stays that of v_.
  void LookAhead() {
    bool stalled = false;
    for (const Island& island : islands_) {
      if (island.phase != Phase::kSearching) continue;
      const double ahead = island.symmetric ? kStepAhead : 0;
      stalled = stalled || island.symmetric;
      ForEachDof(island, [&](int dof) { trial_[dof] = v_[dof] + ahead * direction_[dof]; });
    }
    if (stalled) Evaluate();
  }

  double ScaleOf(const Island& island) {
    return std::max(island.drive, equations_.ContactChange(island.joined));
  }

  bool Converged(const Island& island) {
    return island.merit <= Square(kStepTolerance * ScaleOf(island));
  }

  void FindDirection(Island* island) {
    BlockMatrix& matrix = island->matrix;
    equations_.Assemble(island->joined, trial_,
                        island->symmetric ? Symmetry::kKept : Symmetry::kNone, 1, &matrix);
    // Blocks stand in the order of the trees, as the island's velocities do.
    std::vector<double> x;
    ForEachDof(*island, [&](int dof) { x.push_back(-equations_.residual()[dof]); });
    if (matrix.Factor()) {
      matrix.Solve(x);
    } else {
      std::ranges::fill(x, 0.0);
    }
    int row = 0;
    ForEachDof(*island, [&](int dof) { direction_[dof] = x[row++]; });
    island->length = 1;
    ++island->iterations;
  }

  // Every searching island steps as far as lessens its residual.
  void LineSearch(Slopes slopes = Slopes::kFound) {
    std::vector<Island*> open;
    for (Island& island : islands_) {
      if (island.phase == Phase::kSearching) open.push_back(&island);
    }
    const std::vector<Island*> searching = open;
    while (!open.empty()) {
      for (Island& island : islands_) island.phase = Phase::kDone;
      for (Island* island : open) {
        island->phase = Phase::kSearching;
        ForEachDof(*island,
                   [&](int dof) { trial_[dof] = v_[dof] + island->length * direction_[dof]; });
      }
      Evaluate(slopes);
      std::erase_if(open, [&](Island* island) { return Judge(island); });
    }
    for (Island* island : searching) {
      island->phase = island->stuck ? Phase::kDone : Phase::kSearching;
    }
  }

  // Whether the island's trial ends its line search.
  bool Judge(Island* island) {
    const double merit = equations_.SetResidual(island->joined, trial_);
    if (island->length > 0 && merit <= (1 - 2 * kStepDecrease * island->length) * island->merit) {
      island->merit = merit;
      island->symmetric = false;
      ForEachDof(*island, [&](int dof) { v_[dof] = trial_[dof]; });
      return true;
    }
    if (island->length > 0) {
      island->length *= 0.5;
      if (island->length < kShortestSearch) island->length = 0;  // back to where it came from
      return false;
    }
    // Forces and residual are again those of v_.
    island->merit = merit;
    if (island->symmetric) {
      island->stuck = true;
      island->status = std::sqrt(merit) <= kStepRoundOff * ScaleOf(*island)
                           ? StepStatus::kRoundOff
                           : StepStatus::kIterationLimit;
    }
    island->symmetric = true;  // the symmetric part always leads downhill where friction sticks
    return true;
  }

  void Finish() {
    const std::shared_ptr<LoadedSprings> loaded = model_.NewLoadedSprings();
    const std::shared_ptr<Forces> forces = model_.NewForces();
    loaded->X_FB = equations_.X_FB();
    loaded->size = 0;
    loaded->num_springs = 0;
    loaded->idle.clear();
    std::vector<StepWork>& works = equations_.works();
    if (loaded->pairs.size() < works.size()) loaded->pairs.resize(works.size());
    forces->springs.clear();
    forces->stretches.clear();
    forces->first.clear();
    forces->pairs.clear();
    for (StepWork& work : works) {
      const SpringSet& springs = work.found.springs;
      if (springs.size() == 0 && springs.status == kNominal) {
        loaded->idle.push_back(work.found.pair);
        continue;
      }
      forces->first.push_back(loaded->num_springs);
      forces->pairs.push_back(work.total);
      forces->springs.insert(forces->springs.end(), work.springs.begin(), work.springs.end());
      forces->stretches.insert(forces->stretches.end(), work.stretches.begin(),
                               work.stretches.end());
      loaded->num_springs += springs.size();
      std::swap(loaded->pairs[loaded->size++], work.found);
    }
    forces->loaded = loaded;
    forces->V_FB = equations_.V_FB();
    forces->state_id = state_.id;
    model_.AddUp(forces.get());
    solution_.forces = forces;
    solution_.v = v_;
    // With what the search left over, so that a step under them ends at just these velocities: what
    // it leaves of stiff springs would throw bodies about otherwise.
    solution_.generalized_forces = equations_.forces();
    for (const Island& island : islands_) {
      ForEachDof(island, [&](int dof) {
        solution_.generalized_forces[dof] += equations_.residual()[dof] / problem_.step;
      });
    }
    solution_.islands = static_cast<int>(islands_.size());
    for (const Island& island : islands_) {
      solution_.iterations = std::max(solution_.iterations, island.iterations);
      solution_.status = std::max(solution_.status, island.status);
      const double drive = ScaleOf(island);
      if (drive > 0) {
        solution_.residual = std::max(solution_.residual, std::sqrt(island.merit) / drive);
      }
    }
  }

  const ContactModel& model_;
  const StepTopology& topology_;
  const StepProblem& problem_;
  const ContactState& state_;
  StepEquations equations_;
  std::vector<double> v_, trial_, direction_;  // accepted, and being tried
  std::vector<Island> islands_;
  StepSolution solution_;
};

StepSolver::StepSolver(std::shared_ptr<const ContactModel> model, StepTopology topology)
    : model_(std::move(model)), topology_(std::move(topology)) {}

StepSolution StepSolver::Solve(const StepProblem& problem, const ContactState& state) const {
  return Search(*this, problem, state).Run();
}

}  // namespace contact_toolkit
