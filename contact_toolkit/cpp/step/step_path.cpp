#include "step/step_path.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/tolerances.h"

namespace contact_toolkit {

StepPath::StepPath(StepEquations* equations, const StepIsland& island)
    : equations_(*equations), island_(island), dofs_(equations->DofsOf(island)) {}

bool StepPath::Follow(std::span<double> v) {
  velocities_.assign(v.begin(), v.end());
  start_.clear();
  for (const int dof : dofs_) start_.push_back(v[dof]);
  weight_ = equations_.FreeEnergy(island_);
  const double whole = std::sqrt(weight_), shortest = kShortestOnPath * whole;
  Point here{start_, 0};
  if (!(weight_ > 0) || !Linearize(here)) return false;
  Point tangent = Tangent();
  double length = kFirstOnPath * whole;
  for (int step = 0; step < kPathSteps && length > shortest; ++step) {
    Point trial = Sum(here, length, tangent);
    const int before = evaluations_;
    if (!Correct(tangent, length, kOnPath * length, &trial) || trial.share < 0) {
      // Shorter, and the way that the path takes behind a kink that it may have here.
      length *= 0.5;
      if (Linearize(Sum(here, length, tangent))) tangent = Tangent();
      continue;
    }
    if (trial.share >= 1) {
      const double rest = (1 - here.share) / (trial.share - here.share);
      Point end = Sum(here, rest, Sum(trial, -1, here));
      if (Correct({std::vector<double>(dofs_.size(), 0.0), 1}, length, shortest, &end)) {
        for (std::size_t i = 0; i < dofs_.size(); ++i) v[dofs_[i]] = end.v[i];
        return true;
      }
      length *= 0.5;
      continue;
    }
    here = trial;
    tangent = Tangent();
    if (evaluations_ - before <= 2) length = std::min(2 * length, kLongestOnPath * whole);
  }
  return false;
}

StepPath::Point StepPath::Sum(Point a, double factor, const Point& b) {
  for (std::size_t i = 0; i < a.v.size(); ++i) a.v[i] += factor * b.v[i];
  a.share += factor * b.share;
  return a;
}

bool StepPath::Linearize(const Point& at) {
  for (std::size_t i = 0; i < dofs_.size(); ++i) velocities_[dofs_[i]] = at.v[i];
  equations_.Evaluate({&island_}, velocities_, Slopes::kFound);
  ++evaluations_;
  equations_.SetResidual(island_, velocities_);
  equations_.Assemble(island_, velocities_, Symmetry::kNone, at.share, &matrix_);
  if (!matrix_.Factor()) return false;
  std::vector<double> way = at.v;
  for (std::size_t i = 0; i < way.size(); ++i) way[i] -= start_[i];
  correction_ = response_ = TimesInertia(way);
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    const double r = equations_.residual()[dofs_[i]], momentum = response_[i];
    correction_[i] = -at.share * r - (1 - at.share) * momentum;
    response_[i] = momentum - r;
  }
  matrix_.Solve(correction_);
  matrix_.Solve(response_);
  return true;
}

bool StepPath::Correct(const Point& tangent, double length, double close, Point* trial) {
  for (int iteration = 0; iteration < kPathCorrections; ++iteration) {
    if (!Linearize(*trial)) return false;
    const Point straight{correction_, 0}, along{response_, 1};
    const Point change =
        Sum(straight, -Product(tangent, straight) / Product(tangent, along), along);
    *trial = Sum(std::move(*trial), 1, change);
    const double size = std::sqrt(Product(change, change));
    if (size <= close) return true;
    if (!(size < 2 * length)) return false;
  }
  return false;
}

StepPath::Point StepPath::Tangent() const {
  Point tangent{response_, 1};
  // The same way round all along: the matrix of H by (v, s), with the tangent below, keeps the sign
  // of its determinant, which is that of dH/dv where s grows.
  const double sign = matrix_.DeterminantIsNegative() ? -1 : 1;
  const double scale = sign / std::sqrt(Product(tangent, tangent));
  for (double& x : tangent.v) x *= scale;
  tangent.share *= scale;
  return tangent;
}

double StepPath::Product(const Point& a, const Point& b) const {
  const std::vector<double> momentum = TimesInertia(b.v);
  return std::inner_product(a.v.begin(), a.v.end(), momentum.begin(), weight_ * a.share * b.share);
}

std::vector<double> StepPath::TimesInertia(const std::vector<double>& v) const {
  std::vector<double> momentum;
  equations_.AppendMomentum(island_, v, &momentum);
  return momentum;
}

}  // namespace contact_toolkit
