// A triangle within a wedge, cut where another of the wedge's sides comes to be the closest one.
// Points are weights of the triangle's corners (barycentric coordinates).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "web/area/clipped_slope.h"
#include "web/area/wedge_regions.h"

namespace contact_toolkit {

struct WedgeCut {
  using Point = std::array<double, 3>;
  using Corners = std::array<Point, 3>;

  explicit WedgeCut(int count) : num_sides(count) {}

  int num_sides;
  std::array<Point, Wedge::kMostSides> depth{};  // [m] beneath each side, at the corners

  static double At(const Point& p, const std::array<double, 3>& value) {
    return p[0] * value[0] + p[1] * value[1] + p[2] * value[2];
  }

  // The side that is the closest one at every corner, so everywhere; -1: none.
  int LeastEverywhere() const {
    for (int s = 0; s < num_sides; ++s) {
      bool least = true;
      for (int t = 0; t < num_sides && least; ++t) {
        for (int k = 0; k < 3; ++k) least = least && depth[s][k] <= depth[t][k];
      }
      if (least) return s;
    }
    return -1;
  }

  // A convex polygon.
  struct Piece {
    static constexpr int kMostCorners = 3 + Wedge::kMostSides - 1;
    std::array<Point, kMostCorners> corner;
    int count = 0;

    // visit(corners, the part of the whole triangle's area).
    template <typename Visit>
    void ForEachTriangle(const Visit& visit) const {
      for (int k = 2; k < count; ++k) {
        const Point &a = corner[0], &b = corner[k - 1], &c = corner[k];
        const double part = a[0] * (b[1] * c[2] - b[2] * c[1]) -
                            a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
        if (part > 0) visit(Corners{a, b, c}, part);
      }
    }

    void KeepWhere(const std::array<double, 3>& value, bool or_zero) {
      Piece kept;
      for (int k = 0; k < count; ++k) {
        const Point &a = corner[k], &b = corner[k + 1 < count ? k + 1 : 0];
        const double at_a = At(a, value), at_b = At(b, value);
        const bool in_a = or_zero ? at_a >= 0 : at_a > 0, in_b = or_zero ? at_b >= 0 : at_b > 0;
        if (in_a && kept.count < kMostCorners) kept.corner[kept.count++] = a;
        if (in_a == in_b || kept.count == kMostCorners) continue;
        const double t = at_a / (at_a - at_b);
        Point& p = kept.corner[kept.count++];
        for (int j = 0; j < 3; ++j) p[j] = a[j] + t * (b[j] - a[j]);
      }
      *this = kept;
    }
  };

  // Where the side is the closest one; of sides equally close everywhere, the first.
  Piece PieceOf(int side) const {
    Piece piece;
    piece.corner[0] = {1, 0, 0}, piece.corner[1] = {0, 1, 0}, piece.corner[2] = {0, 0, 1};
    piece.count = 3;
    for (int t = 0; t < num_sides && piece.count > 2; ++t) {
      if (t != side) piece.KeepWhere(Difference(t, side), side < t);
    }
    return piece;
  }

  // The border between the pieces of two sides: ∫ N_i N_j d over it, for each metre by which it
  // moves when one side comes closer by so much. False where they do not meet.
  bool BorderOf(int s, int t, double area, Coupling* moved) const {
    const std::array<double, 3> e = Difference(s, t);
    const int positive = (e[0] > 0) + (e[1] > 0) + (e[2] > 0);
    if (positive == 0 || positive == 3) return false;
    const bool lone = positive == 1;
    const int a = (e[0] > 0) == lone ? 0 : (e[1] > 0) == lone ? 1 : 2;
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    if (e[a] == 0) return false;
    const double to_b = e[a] / (e[a] - e[b]), to_c = e[a] / (e[a] - e[c]);
    Point start{}, end{};
    start[a] = 1 - to_b, start[b] = to_b;
    end[a] = 1 - to_c, end[c] = to_c;
    // What of it is under both, and under no other side less.
    double from = 0, to = 1;
    const auto keep = [&](const std::array<double, 3>& value) {
      const double first = At(start, value), last = At(end, value);
      if (first < 0 && last < 0) to = from;
      if (first < 0 && last >= 0) from = std::max(from, first / (first - last));
      if (first >= 0 && last < 0) to = std::min(to, first / (first - last));
    };
    keep(depth[s]);
    for (int u = 0; u < num_sides; ++u) {
      if (u != s && u != t) keep(Difference(u, s));
    }
    if (!(to > from)) return false;
    // How fast the area within e > 0 changes with e, by Simpson's rule along the border.
    const double rate = 2 * area * to_b * to_c / std::abs(e[a]) * (to - from);
    for (int q = 0; q < 3; ++q) {
      const double along = from + 0.5 * q * (to - from), weight = q == 1 ? 4.0 / 6 : 1.0 / 6;
      Point p;
      for (int j = 0; j < 3; ++j) p[j] = start[j] + along * (end[j] - start[j]);
      const double d = std::max(0.0, At(p, depth[s]));
      const double load = rate * weight * d;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) (*moved)[i][j] += load * p[i] * p[j];
      }
    }
    return true;
  }

 private:
  std::array<double, 3> Difference(int s, int t) const {
    return {depth[s][0] - depth[t][0], depth[s][1] - depth[t][1], depth[s][2] - depth[t][2]};
  }
};

}  // namespace contact_toolkit
