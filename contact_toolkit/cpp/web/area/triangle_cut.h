// How triangles of a surface are cut into well-shaped parts. Edges are only ever halved, by a rule
// that asks nothing but the edge, so the smallest parts on both sides of one conform.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "math/vec.h"

namespace contact_toolkit {

using Corners = std::array<Vec3, 3>;

inline constexpr double kWellShaped = 1.5;  // a triangle's edges, of the shortest one's length

// Calls emit(part) for the parts of a triangle, two of whose edges are long beside its third, from
// a to b: these edges are cut into pieces about as long as that, and what lies between is stitched
// together. Cut in the middle again and again such a triangle would leave ever narrower ones.
template <typename Splits, typename Emit>
bool CutAcross(const Vec3& apex, const Vec3& a, const Vec3& b, const Splits& splits,
               const Emit& emit) {
  const double enough = kWellShaped * kWellShaped * SquaredNorm(b - a);
  const auto pieces = [&](const Vec3& end) {
    std::vector<Vec3> points{apex}, ends{end};
    while (!ends.empty()) {
      const Vec3 &from = points.back(), to = ends.back();
      if (SquaredNorm(to - from) > enough && splits(from, to)) {
        ends.push_back(0.5 * (from + to));
      } else {
        points.push_back(to);
        ends.pop_back();
      }
    }
    return points;
  };
  const std::vector<Vec3> p = pieces(a), q = pieces(b);
  if (p.size() == 2 && q.size() == 2) return false;
  emit({apex, p[1], q[1]});
  for (std::size_t i = 1, j = 1; i + 1 < p.size() || j + 1 < q.size();) {
    const bool along_p =
        j + 1 == q.size() ||
        (i + 1 < p.size() && SquaredNorm(q[j] - p[i + 1]) < SquaredNorm(q[j + 1] - p[i]));
    if (along_p) {
      emit({p[i], p[i + 1], q[j]});
      ++i;
    } else {
      emit({p[i], q[j + 1], q[j]});
      ++j;
    }
  }
  return true;
}

// Calls emit(part) for the parts of a triangle whose edges are cut at between(a, b) where
// splits(a, b) asks for it; false where it needs no cut.
template <typename Splits, typename Between, typename Emit>
bool CutInHalves(const Corners& t, const Splits& splits, const Between& between, const Emit& emit) {
  bool split[3];
  int count = 0, first = -1;
  for (int k = 0; k < 3; ++k) {
    split[k] = splits(t[k], t[(k + 1) % 3]);
    if (split[k]) ++count, first = k;
  }
  const auto middle = [&](int k) { return between(t[k % 3], t[(k + 1) % 3]); };
  if (count == 3) {
    const Vec3 m[3] = {middle(0), middle(1), middle(2)};
    emit({t[0], m[0], m[2]});
    emit({m[0], t[1], m[1]});
    emit({m[2], m[1], t[2]});
    emit({m[0], m[1], m[2]});
  } else if (count == 1) {
    const Vec3 &a = t[first], &b = t[(first + 1) % 3], &c = t[(first + 2) % 3], m = middle(first);
    emit({a, m, c});
    emit({m, b, c});
  } else if (count == 2) {
    // Turned so that the edge from b to c stays whole; the quadrilateral by its shorter diagonal.
    int k = 0;
    while (split[(k + 1) % 3]) ++k;
    const Vec3 &a = t[k], &b = t[(k + 1) % 3], &c = t[(k + 2) % 3];
    const Vec3 ab = middle(k), ca = middle(k + 2);
    emit({a, ab, ca});
    if (SquaredNorm(c - ab) < SquaredNorm(b - ca)) {
      emit({ab, b, c});
      emit({ab, c, ca});
    } else {
      emit({ab, b, ca});
      emit({b, c, ca});
    }
  }
  return count > 0;
}

// The same in the middle, after what is too narrow for that.
template <typename Splits, typename Emit>
bool CutOnce(const Corners& t, const Splits& splits, const Emit& emit) {
  double squared[3];
  for (int k = 0; k < 3; ++k) squared[k] = SquaredNorm(t[(k + 1) % 3] - t[k]);
  const int base = static_cast<int>(std::min_element(squared, squared + 3) - squared);
  return CutAcross(t[(base + 2) % 3], t[base], t[(base + 1) % 3], splits, emit) ||
         CutInHalves(t, splits, [](const Vec3& a, const Vec3& b) { return 0.5 * (a + b); }, emit);
}

// Calls emit(part) for the parts that need no further cut.
template <typename Splits, typename Emit>
void CutUntil(const Corners& t, const Splits& splits, const Emit& emit) {
  const auto again = [&](const Corners& part) { CutUntil(part, splits, emit); };
  if (!CutOnce(t, splits, again)) emit(t);
}

}  // namespace contact_toolkit
