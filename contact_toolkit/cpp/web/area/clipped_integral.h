// The integral of a linear deformation over the part of a triangle where it is positive, shared
// between the corners: I_j = ∫ N_j max(0, Σ N_k d_k)^n dA, N the barycentric coordinates. K I_j is
// the derivative of the stored energy K/(n + 1) ∫ max(0, ·)^{n+1} dA with respect to d_j.
#pragma once

#include <array>
#include <cmath>

namespace contact_toolkit {

// n = 1, in closed form. Adds to I.
inline void AddClippedIntegral(double area, const std::array<double, 3>& d,
                               std::array<double*, 3> I) {
  const auto add_whole = [&] {
    const double sum = d[0] + d[1] + d[2];
    for (int j = 0; j < 3; ++j) *I[j] += area / 12 * (d[j] + sum);
  };
  // The corner of the triangle where `sign` d is positive at corner a alone.
  const auto add_corner = [&](int a, double sign) {
    const int b = a == 2 ? 0 : a + 1, c = a == 0 ? 2 : a - 1;
    const double s = d[a] / (d[a] - d[b]), t = d[a] / (d[a] - d[c]);
    const double share = area * s * t * (sign * d[a]) / 12;
    *I[a] += share * (4 - s - t), *I[b] += share * s, *I[c] += share * t;
  };
  const int positive = (d[0] > 0) + (d[1] > 0) + (d[2] > 0);
  if (positive == 0) return;
  if (positive == 3) return add_whole();
  const bool lone = positive == 1;
  const int odd = (d[0] > 0) == lone ? 0 : (d[1] > 0) == lone ? 1 : 2;
  if (!lone) add_whole();  // less the corner where the deformation is negative
  if (lone || d[odd] < 0) add_corner(odd, lone ? 1 : -1);
}

// The points of the 12-point rule of degree 6 (Dunavant, "High degree efficient symmetrical
// Gaussian quadrature rules for the triangle", 1985) where the deformation is positive: `visit` is
// given the weight, the barycentric coordinates and the deformation.
template <typename Visit>
void ForEachLoadedPoint(const std::array<double, 3>& d, const Visit& visit) {
  struct Orbit {
    double weight, a, b;  // barycentric (a, b, 1 - a - b) and its permutations
    int points;
  };
  static constexpr Orbit kOrbits[] = {
      {0.116786275726379, 0.501426509658179, 0.249286745170910, 3},
      {0.050844906370207, 0.873821971016996, 0.063089014491502, 3},
      {0.082851075618374, 0.053145049844817, 0.310352451033784, 6},
  };
  static constexpr int kPermutations[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                              {0, 2, 1}, {1, 0, 2}, {2, 1, 0}};
  for (const Orbit& orbit : kOrbits) {
    const double value[3] = {orbit.a, orbit.b, 1 - orbit.a - orbit.b};
    for (int p = 0; p < orbit.points; ++p) {
      std::array<double, 3> N;
      double depth = 0;
      for (int j = 0; j < 3; ++j) N[j] = value[kPermutations[p][j]], depth += N[j] * d[j];
      if (depth > 0) visit(orbit.weight, N, depth);
    }
  }
}

// Any n, by that rule. The energy is the same sum, so forces are its gradient.
inline void AddClippedIntegral(double area, const std::array<double, 3>& d, double n,
                               std::array<double*, 3> I) {
  ForEachLoadedPoint(d, [&](double weight, const std::array<double, 3>& N, double depth) {
    const double load = weight * area * std::pow(depth, n);
    for (int j = 0; j < 3; ++j) *I[j] += load * N[j];
  });
}

}  // namespace contact_toolkit
