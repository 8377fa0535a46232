#include "step/step_equations.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/parallel.h"
#include "base/tolerances.h"
#include "contact/broad_phase.h"
#include "math/dense.h"
#include "step/pair_derivative.h"

namespace contact_toolkit {
namespace {

double Square(double x) { return x * x; }

}  // namespace

Mat6 InertiaInF(const StepTopology& topology, int index, std::span<const double> q0) {
  Mat6 I_R;
  std::copy_n(topology.inertia_R.data() + 36 * index, 36, &I_R.m[0][0]);
  return Turned(RotationOf(q0.data() + topology.trees[index].q_start), I_R);
}

StepEquations::StepEquations(const ContactModel& model, const StepTopology& topology,
                             const StepProblem& problem, const ContactState& state)
    : model_(model),
      topology_(topology),
      problem_(problem),
      state_(state),
      kinematics_(topology, problem),
      f_(problem.v_free.size(), 0.0),
      residual_(problem.v_free.size(), 0.0),
      trees_(topology.trees.size()),
      X_FB_(topology.bodies.size()),
      V_FB_(topology.bodies.size()),
      squeeze_(topology.bodies.size(), 0.0),
      lightness_(topology.bodies.size(), -1.0) {}

void StepEquations::Place(int body, std::span<const double> v) {
  X_FB_[body] = kinematics_.PoseOf(body, v);
  V_FB_[body] = kinematics_.TwistOf(body, v);
}

std::vector<int> StepEquations::PairsAt(std::span<const double> v) {
  for (std::size_t i = 0; i < X_FB_.size(); ++i) Place(static_cast<int>(i), v);
  return PairsInReach(model_.geometries(), model_.pairs(), X_FB_);
}

bool StepEquations::AddPairs(std::span<const double> v) { return TakeUp(PairsAt(v)); }

bool StepEquations::AddPairs(std::span<const double> v, std::span<const double> also_v) {
  const std::vector<int> also = PairsAt(also_v), at = PairsAt(v);
  std::vector<int> all;
  std::ranges::set_union(at, also, std::back_inserter(all));
  return TakeUp(all);
}

bool StepEquations::TakeUp(const std::vector<int>& pairs) {
  std::vector<int> known;
  for (const StepWork& work : works_) known.push_back(work.found.pair);
  std::vector<int> fresh;
  std::ranges::set_difference(pairs, known, std::back_inserter(fresh));
  std::erase_if(fresh, [this](int pair) {
    return TreeOf(model_.pairs()[pair].a) < 0 && TreeOf(model_.pairs()[pair].b) < 0;
  });
  for (const int pair : fresh) {
    works_.emplace_back();
    works_.back().found.pair = pair;
  }
  std::ranges::sort(works_, {}, [](const StepWork& work) { return work.found.pair; });
  return !fresh.empty();
}

std::vector<StepIsland> StepEquations::MakeIslands() {
  std::vector<int> parent(trees_.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int tree) {
    while (parent[tree] != tree) tree = parent[tree] = parent[parent[tree]];
    return tree;
  };
  std::vector<bool> used(trees_.size(), false);
  for (const StepWork& work : works_) {
    const ContactPair& pair = model_.pairs()[work.found.pair];
    const int a = TreeOf(pair.a), b = TreeOf(pair.b);
    if (a >= 0) used[a] = true;
    if (b >= 0) used[b] = true;
    if (a >= 0 && b >= 0) parent[std::max(root(a), root(b))] = std::min(root(a), root(b));
  }
  std::vector<StepIsland> islands;
  std::vector<int> of_root(trees_.size(), -1), of_tree(trees_.size(), -1);
  for (std::size_t i = 0; i < trees_.size(); ++i) {
    if (!used[i]) continue;
    const int tree = static_cast<int>(i);
    int& island = of_root[root(tree)];
    if (island < 0) {
      island = static_cast<int>(islands.size());
      islands.emplace_back();
    }
    of_tree[i] = island;
    trees_[i].block = static_cast<int>(islands[island].trees.size());
    islands[island].trees.push_back(tree);
    if (trees_[i].inertia.empty()) SetInertia(tree);
  }
  for (std::size_t i = 0; i < works_.size(); ++i) {
    const ContactPair& pair = model_.pairs()[works_[i].found.pair];
    islands[of_tree[std::max(TreeOf(pair.a), TreeOf(pair.b))]].works.push_back(static_cast<int>(i));
  }
  for (std::size_t body = 0; body < topology_.bodies.size(); ++body) {
    const int tree = topology_.bodies[body].tree;
    if (tree >= 0 && of_tree[tree] >= 0) {
      islands[of_tree[tree]].bodies.push_back(static_cast<int>(body));
    }
  }
  return islands;
}

bool StepEquations::WasInContact(const StepIsland& island) const {
  return std::ranges::any_of(island.works, [this](int work) {
    const PairState known = state_.StateOf(works_[work].found.pair);
    return known.anchors || known.memory;
  });
}

double StepEquations::SquaredSizeOf(const StepIsland& island, const auto& velocity) const {
  double square = 0;
  for (const int index : island.trees) {
    const StepTree& tree = topology_.trees[index];
    const std::vector<double>& A = trees_[index].inertia;
    for (int i = 0; i < tree.nv; ++i) {
      for (int j = 0; j < tree.nv; ++j) {
        square += velocity(tree.v_start + i) * A[i * tree.nv + j] * velocity(tree.v_start + j);
      }
    }
  }
  return std::max(0.0, square);
}

std::vector<int> StepEquations::DofsOf(const StepIsland& island) const {
  std::vector<int> dofs;
  for (const int index : island.trees) {
    const StepTree& tree = topology_.trees[index];
    for (int i = 0; i < tree.nv; ++i) dofs.push_back(tree.v_start + i);
  }
  return dofs;
}

void StepEquations::AppendMomentum(const StepIsland& island, std::span<const double> v,
                                   std::vector<double>* momentum) const {
  for (const int index : island.trees) {
    const int n = topology_.trees[index].nv;
    const double* A = trees_[index].inertia.data();
    for (int i = 0; i < n; ++i) {
      momentum->push_back(std::inner_product(A + i * n, A + (i + 1) * n, v.begin(), 0.0));
    }
    v = v.subspan(n);
  }
}

double StepEquations::FreeChange(const StepIsland& island) const {
  return std::sqrt(
      SquaredSizeOf(island, [this](int dof) { return problem_.v_free[dof] - problem_.v0[dof]; }));
}

double StepEquations::FreeEnergy(const StepIsland& island) const {
  return SquaredSizeOf(island, [this](int dof) { return problem_.v_free[dof]; });
}

void StepEquations::SetInertia(int index) {
  const StepTree& tree = topology_.trees[index];
  std::vector<double>& A = trees_[index].inertia;
  A.resize(tree.nv * tree.nv);
  if (tree.q_start >= 0) {
    const Mat6 turned = InertiaInF(topology_, index, problem_.q0);
    std::copy_n(&turned.m[0][0], 36, A.data());
  } else {
    const std::size_t nv = topology_.num_velocities;
    for (int i = 0; i < tree.nv; ++i) {
      const double* row = problem_.inertia.data() + (tree.v_start + i) * nv + tree.v_start;
      std::copy_n(row, tree.nv, A.data() + i * tree.nv);
    }
  }
  trees_[index].factor = A;
  if (!FactorCholesky(tree.nv, trees_[index].factor.data())) trees_[index].factor.clear();
}

void StepEquations::Evaluate(const std::vector<const StepIsland*>& islands,
                             std::span<const double> v, Slopes slopes) {
  std::vector<int> active;
  for (const StepIsland* island : islands) {
    for (const int body : island->bodies) Place(body, v);
    active.insert(active.end(), island->works.begin(), island->works.end());
  }
  ParallelFor(static_cast<int>(active.size()), model_.threads(), [&](int i, int) {
    StepWork& work = works_[active[i]];
    work.found.springs.slopes.wanted = slopes == Slopes::kFound;
    const Pose last_X_AB = work.found.X_AB;
    const bool known = model_.FindPair(work.found.pair, X_FB_, &state_, &work.found);
    if (!known && work.tried) model_.LookAround(last_X_AB, &state_, &work.found);
    work.tried = true;
    const std::size_t size = work.found.springs.size();
    work.stretches.resize(size);
    work.springs.resize(size);
    work.total =
        model_.ComputePair(work.found, X_FB_, V_FB_, &state_, work.stretches, work.springs);
  });
  for (const StepIsland* island : islands) AddUpForces(*island);
}

void StepEquations::AddUpForces(const StepIsland& island) {
  for (const int index : island.trees) {
    const StepTree& tree = topology_.trees[index];
    std::fill_n(f_.begin() + tree.v_start, tree.nv, 0.0);
  }
  for (const int body : island.bodies) squeeze_[body] = 0;
  for (const int i : island.works) {
    const StepWork& work = works_[i];
    if (work.found.springs.size() == 0) continue;
    const ContactPair& pair = model_.pairs()[work.found.pair];
    const Mat3& R = work.found.X_FA.R;
    const Vec3 force = R * work.total.force, torque = R * work.total.torque;
    double sum = 0;
    for (const SpringForce& spring : work.springs) sum += std::abs(spring.normal);
    const auto push = [&](int geometry, double sign) {
      const int body = model_.geometries()[geometry].body;
      squeeze_[body] += sum;
      Push(body, work.found.X_FA.p, torque * sign, force * sign, f_.data());
    };
    push(pair.a, 1);
    push(pair.b, -1);
  }
}

// Adds to the generalized forces f a wrench about the point P on a body.
void StepEquations::Push(int body, const Vec3& p_FP, const Vec3& torque, const Vec3& force,
                         double* f) const {
  const StepBody& moving = topology_.bodies[body];
  if (moving.tree < 0) return;
  const StepTree& tree = topology_.trees[moving.tree];
  const Vec3 moment = torque + Cross(p_FP - kinematics_.OriginOf(body, X_FB_[body]), force);
  if (tree.q_start >= 0) {
    for (int i = 0; i < 3; ++i) {
      f[tree.v_start + i] += moment[i];
      f[tree.v_start + 3 + i] += force[i];
    }
    return;
  }
  const double F[6] = {moment.x, moment.y, moment.z, force.x, force.y, force.z};
  const std::size_t nv = topology_.num_velocities;
  const double* J = problem_.jacobian.data() + 6 * nv * body + tree.v_start;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < tree.nv; ++k) f[tree.v_start + k] += J[i * nv + k] * F[i];
  }
}

double StepEquations::SetResidual(const StepIsland& island, std::span<const double> v) {
  double merit = 0;
  for (const int index : island.trees) {
    const StepTree& tree = topology_.trees[index];
    const std::vector<double>& A = trees_[index].inertia;
    double* r = residual_.data() + tree.v_start;
    for (int i = 0; i < tree.nv; ++i) {
      double sum = 0;
      for (int j = 0; j < tree.nv; ++j) {
        const int dof = tree.v_start + j;
        sum += A[i * tree.nv + j] * (v[dof] - problem_.v_free[dof]);
      }
      r[i] = sum - problem_.step * f_[tree.v_start + i];
    }
    merit += SizeOf(index, r);
  }
  return merit;
}

// xᵀ A⁻¹ x
double StepEquations::SizeOf(int index, const double* x) const {
  const Tree& tree = trees_[index];
  const int n = topology_.trees[index].nv;
  if (tree.factor.empty()) return 0;
  std::vector<double> y(x, x + n);
  SolveLower(n, tree.factor.data(), y.data());
  return std::inner_product(y.begin(), y.end(), y.begin(), 0.0);
}

double StepEquations::ContactChange(const StepIsland& island) {
  double impulse = 0, squeeze = 0, still = 0;
  for (const int index : island.trees) {
    impulse += SizeOf(index, f_.data() + topology_.trees[index].v_start);
  }
  for (const int body : island.bodies) {
    if (squeeze_[body] == 0 || LightnessOf(body) == 0) continue;
    squeeze += Square(kStepSqueeze * squeeze_[body]) * LightnessOf(body);
    still += Square(kStepStill) / LightnessOf(body);
  }
  return std::sqrt(std::max(Square(problem_.step) * std::max(impulse, squeeze), still));
}

// |Jᵀ e|² in the metric of A⁻¹, for the direction e in which a force on the body does most: for a
// free one, the inverse of its mass.
double StepEquations::LightnessOf(int body) {
  double& lightness = lightness_[body];
  if (lightness >= 0) return lightness;
  const int index = topology_.bodies[body].tree;
  std::vector<double> f(f_.size());
  for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
    std::ranges::fill(f, 0.0);
    Push(body, X_FB_[body].p, {}, axis, f.data());
    lightness = std::max(lightness, SizeOf(index, f.data() + topology_.trees[index].v_start));
  }
  return lightness;
}

void StepEquations::Assemble(const StepIsland& island, std::span<const double> v, Symmetry symmetry,
                             double share, BlockMatrix* matrix) const {
  std::vector<int> sizes;
  for (const int tree : island.trees) sizes.push_back(topology_.trees[tree].nv);
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  for (const int i : island.works) {
    const ContactPair& pair = model_.pairs()[works_[i].found.pair];
    const int a = TreeOf(pair.a), b = TreeOf(pair.b);
    if (a >= 0 && b >= 0 && a != b && works_[i].found.springs.size() > 0) {
      edges.emplace_back(trees_[a].block, trees_[b].block);
    }
  }
  matrix->Reset(sizes, edges);
  for (std::size_t i = 0; i < island.trees.size(); ++i) {
    const std::vector<double>& A = trees_[island.trees[i]].inertia;
    std::ranges::copy(A, matrix->Block(static_cast<int>(i), static_cast<int>(i)));
  }
  for (const int i : island.works) {
    if (works_[i].found.springs.size() > 0) AddPair(works_[i], v, symmetry, share, matrix);
  }
}

void StepEquations::AddPair(const StepWork& work, std::span<const double> v, Symmetry symmetry,
                            double share, BlockMatrix* matrix) const {
  const ContactPair& pair = model_.pairs()[work.found.pair];
  PairLinearization linear;
  model_.LinearizeFound(work.found, X_FB_, V_FB_, &state_, symmetry, &linear);
  const Vec3& p_FP = work.found.X_FA.p;
  int trees[2];
  PairDerivative::Body bodies[2];
  std::vector<BodyKinematics::Change> changes[2];
  for (int s = 0; s < 2; ++s) {
    const int body = model_.geometries()[s == 0 ? pair.a : pair.b].body;
    const Twist& V = V_FB_[body];
    bodies[s] = {p_FP - kinematics_.OriginOf(body, X_FB_[body]),
                 {V.w, V.v + Cross(V.w, p_FP - X_FB_[body].p)}};
    trees[s] = topology_.bodies[body].tree;
    if (trees[s] >= 0) kinematics_.Differentiate(body, v, &changes[s]);
  }
  const Mat3& R = work.found.X_FA.R;
  const Slope wrench{R * work.total.torque, R * work.total.force};
  const PairDerivative derivative(linear, R, wrench, bodies[0], bodies[1], symmetry);
  for (int t = 0; t < 2; ++t) {
    for (const BodyKinematics::Change& change : changes[t]) {
      const auto moved = t == 0 ? derivative.ByA(change) : derivative.ByB(change);
      for (int s = 0; s < 2; ++s) {
        if (trees[s] < 0) continue;
        const Slope& on = s == 0 ? moved.on_a : moved.on_b;
        const int columns = topology_.trees[trees[t]].nv;
        double* column = matrix->Block(trees_[trees[s]].block, trees_[trees[t]].block) + change.dof;
        for (const BodyKinematics::Change& with : changes[s]) {
          const double f = Dot(with.spin, on.rotation) + Dot(with.speed, on.translation);
          column[with.dof * columns] -= share * problem_.step * f;
        }
      }
    }
  }
}

}  // namespace contact_toolkit
