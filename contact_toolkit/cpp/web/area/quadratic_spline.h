// Tri-quadratic B-splines on a lattice: value, gradient and second derivatives at a point.
#pragma once

#include <cstdint>
#include <cstring>

#include "math/vec.h"

namespace contact_toolkit {

// The first of the three lattice points whose basis functions reach x: the one before the closest.
inline std::int32_t LowestPoint(double x) {
  const auto truncated = static_cast<std::int32_t>(x + 0.5);
  return truncated - (x + 0.5 < truncated) - 1;
}

// Three numbers in a row, in pairs: GCC 12 splits wider vectors into single numbers where the CPU
// has none.
struct SplineRow {
  using Pair = double __attribute__((vector_size(16)));

  SplineRow() = default;
  explicit SplineRow(const double* from) {  // reads one more
    std::memcpy(&low, from, sizeof low);
    std::memcpy(&high, from + 2, sizeof high);
  }
  double Times(const double* weight) const {
    return weight[0] * low[0] + weight[1] * low[1] + weight[2] * high[0];
  }

  Pair low, high;
};

// The value and the gradient, by lattice spacing, of a tri-quadratic spline over 27 numbers, given
// the basis functions and their slopes along each axis.
struct SplineBasis {
  double w[3][3], dw[3][3];
};
struct SplineValue {
  double value;
  Vec3 slope;
};

inline SplineRow Sum(const double* weight, const SplineRow* lines) {
  SplineRow sum;
  sum.low = weight[0] * lines[0].low + weight[1] * lines[1].low + weight[2] * lines[2].low;
  sum.high = weight[0] * lines[0].high + weight[1] * lines[1].high + weight[2] * lines[2].high;
  return sum;
}

inline SplineValue EvaluateSpline(const SplineBasis& basis, const double* first, int row,
                                  int plane) {
  const auto& [w, dw] = basis;
  // Summed along x, y and z in turn.
  SplineRow value_y[3], slope_y[3];
  for (int j = 0; j < 3; ++j) {
    const SplineRow at[3] = {SplineRow(first + j * row), SplineRow(first + plane + j * row),
                             SplineRow(first + 2 * plane + j * row)};
    value_y[j] = Sum(w[0], at);
    slope_y[j] = Sum(dw[0], at);
  }
  const SplineRow value_z = Sum(w[1], value_y);
  return {value_z.Times(w[2]),
          {Sum(w[1], slope_y).Times(w[2]), Sum(dw[1], value_y).Times(w[2]), value_z.Times(dw[2])}};
}

// Its second derivatives, by lattice spacing squared.
inline Symmetric3 BendSpline(const SplineBasis& basis, const double* first, int row, int plane) {
  static constexpr double kBend[3] = {1, -2, 1};  // second derivatives of the basis functions
  const auto& [w, dw] = basis;
  SplineRow value_y[3], slope_y[3], bend_y[3];
  for (int j = 0; j < 3; ++j) {
    const SplineRow at[3] = {SplineRow(first + j * row), SplineRow(first + plane + j * row),
                             SplineRow(first + 2 * plane + j * row)};
    value_y[j] = Sum(w[0], at);
    slope_y[j] = Sum(dw[0], at);
    bend_y[j] = Sum(kBend, at);
  }
  const SplineRow value_z = Sum(w[1], value_y), slope_z = Sum(w[1], slope_y);
  return {Sum(w[1], bend_y).Times(w[2]), Sum(kBend, value_y).Times(w[2]),
          value_z.Times(kBend),          Sum(dw[1], slope_y).Times(w[2]),
          slope_z.Times(dw[2]),          Sum(dw[1], value_y).Times(dw[2])};
}

}  // namespace contact_toolkit
