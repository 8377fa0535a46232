// Solves a step where Newton's method finds no way: contact is let in little by little. The
// velocities without any are known; as the share s of contact grows from 0 to 1, the solution of
//   H(v, s) = s r(v) + (1 − s) A (v − v_start) = 0,   r(v) = A (v − v_free) − h f(v),
// draws a path from v_start to one of r = 0: it stays bounded, since what contact forces at the end
// of a step can give is (they only brake, but for what springs already loaded give back). Where a
// solution vanishes, the path turns back in s, so it is followed by its length (Chow, Mallet-Paret
// and Yorke, Math. Comp. 32, 1978; Allgower and Georg, Numerical Continuation Methods, 1990). Only
// forces that jump can break it.
#pragma once

#include <span>
#include <vector>

#include "step/block_matrix.h"
#include "step/step_equations.h"

namespace contact_toolkit {

// Of one island. Lengths are in the metric of A, and s counts for the size of v_free.
class StepPath {
 public:
  // Both outlive it.
  StepPath(StepEquations* equations, const StepIsland& island);

  // Leads from `v` (nv), which is v_start, to velocities near a solution, and leaves them there;
  // whether it arrived. Only the island's velocities change.
  bool Follow(std::span<double> v);

  int evaluations() const { return evaluations_; }  // of the contact forces

 private:
  struct Point {
    std::vector<double> v;  // of the island's degrees of freedom
    double share = 0;
  };

  static Point Sum(Point a, double factor, const Point& b);  // a + factor b

  // Where `at` should move for H = 0 at its share, and with each unit of share; false where that is
  // not to be told.
  bool Linearize(const Point& at);
  // From a step's length along `tangent` onto the path, across that, until it gains less than
  // `close`; false where it does not or strays.
  bool Correct(const Point& tangent, double length, double close, Point* trial);
  // Along the path, from what was last linearized.
  Point Tangent() const;
  std::vector<double> TimesInertia(const std::vector<double>& v) const;
  double Product(const Point& a, const Point& b) const;

  StepEquations& equations_;
  const StepIsland& island_;
  std::vector<int> dofs_;
  std::vector<double> start_;
  std::vector<double> velocities_;  // (nv)
  double weight_ = 0;               // of s
  std::vector<double> correction_, response_;
  BlockMatrix matrix_;
  int evaluations_ = 0;
};

}  // namespace contact_toolkit
