// How the integrals of clipped_integral.h change with the deformations at the corners:
// ∂I_i/∂d_j = n ∫ N_i N_j max(0, Σ N_k d_k)^{n−1} dA, symmetric and positive semidefinite.
#pragma once

#include <array>
#include <cmath>

#include "web/area/clipped_integral.h"

namespace contact_toolkit {

using Coupling = std::array<std::array<double, 3>, 3>;

// n = 1, in closed form.
inline Coupling ClippedSlope(double area, const std::array<double, 3>& d) {
  Coupling J{};
  const int positive = (d[0] > 0) + (d[1] > 0) + (d[2] > 0);
  if (positive == 0) return J;
  const bool lone = positive == 1;
  if (!lone) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) J[i][j] = area / 12 * (i == j ? 2 : 1);
    }
    if (positive == 3) return J;
  }
  // The corner cut off, where d is positive at a alone, or negative (then taken away again): its
  // energy is that of E = A d_a⁴/(12 (d_a − d_b)(d_a − d_c)).
  const int a = (d[0] > 0) == lone ? 0 : (d[1] > 0) == lone ? 1 : 2;
  if (!lone && !(d[a] < 0)) return J;
  const int b = a == 2 ? 0 : a + 1, c = a == 0 ? 2 : a - 1;
  const double s = d[a] / (d[a] - d[b]), t = d[a] / (d[a] - d[c]);
  const double share = (lone ? area : -area) * s * t / 12;
  J[a][a] += share * (12 - 8 * (s + t) + 2 * (s * s + s * t + t * t));
  J[b][b] += share * 2 * s * s;
  J[c][c] += share * 2 * t * t;
  const double ab = share * s * (4 - t - 2 * s), ac = share * t * (4 - s - 2 * t);
  J[a][b] += ab, J[b][a] += ab;
  J[a][c] += ac, J[c][a] += ac;
  J[b][c] += share * s * t, J[c][b] += share * s * t;
  return J;
}

// Any n, by the rule that the integrals are summed by.
inline Coupling ClippedSlope(double area, const std::array<double, 3>& d, double n) {
  Coupling J{};
  ForEachLoadedPoint(d, [&](double weight, const std::array<double, 3>& N, double depth) {
    const double slope = n * weight * area * std::pow(depth, n - 1);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) J[i][j] += slope * N[i] * N[j];
    }
  });
  return J;
}

}  // namespace contact_toolkit
