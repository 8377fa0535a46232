// The energy of two crossing sharp edges, see EdgeFillets, with its derivatives as B moves.
#pragma once

#include <array>
#include <cmath>

#include "math/dual.h"
#include "math/vec.h"
#include "shapes/sharp_edges.h"

namespace contact_toolkit {

// The windows: narrower ones make the force jump.
constexpr double kEndWindow = 4;                  // radii from an end over which the force grows
constexpr double kParallelWindow = 0.03;          // of sin² between the edges
constexpr double kConeWindow = 0.2;               // of the normal's margin within the normal cone
constexpr double kDepthFull = 2, kDepthGone = 6;  // radii: the total force still grows throughout

template <class T>
DualOf<T> SmoothStep(const DualOf<T>& x) {
  if (Plain(x) <= 0) return 0.0;
  if (Plain(x) >= 1) return 1.0;
  return Chain(x, x.value * x.value * (3.0 - 2.0 * x.value), 6.0 * x.value * (1.0 - x.value));
}

template <class T>
Vec3Of<T> Fixed(const Vec3& a) {
  return {a.x, a.y, a.z};
}

// A direction or point of B, with its derivatives as B moves: velocities along the axes of A, then
// rotations about them through Ao.
template <class T>
Vec3Of<DualOf<T>> Moving(const Vec3Of<T>& a, bool point) {
  Vec3Of<DualOf<T>> r{a.x, a.y, a.z};
  if (point) r.x.slope[0] = 1.0, r.y.slope[1] = 1.0, r.z.slope[2] = 1.0;
  r.y.slope[3] = -a.z, r.z.slope[3] = a.y;
  r.x.slope[4] = a.z, r.z.slope[4] = -a.x;
  r.x.slope[5] = -a.y, r.y.slope[5] = a.x;
  return r;
}

struct EdgeLine {
  Vec3 start, along;  // `along`: unit
  double length;
  std::array<Vec3, 2> into;
};

template <class T>
struct MovingEdge {
  Vec3Of<T> start, along;
  double length;
  std::array<Vec3Of<T>, 2> into;
};

inline MovingEdge<double> EdgeAt(const StraightEdge& edge) {
  const auto plain = [](const Vec3& a) { return Vec3Of<double>{a.x, a.y, a.z}; };
  const double length = Norm(edge.ends[1] - edge.ends[0]);
  return {plain(edge.ends[0]),
          plain((edge.ends[1] - edge.ends[0]) / length),
          length,
          {plain(edge.into[0]), plain(edge.into[1])}};
}

template <class T>
struct CrossingValue {
  DualOf<T> energy;  // without its constant factor
  DualOf<T> depth;
  DualOf<T> at_a, at_b;  // [m] from the starts of the edges to the crossing
};

// `outwards`: 1 or −1, so that outwards (along_a × along_b) leaves A.
template <class T>
CrossingValue<T> CrossingEnergy(const EdgeLine& a, const MovingEdge<T>& b, double outwards,
                                double r, double exponent) {
  using D = DualOf<T>;
  using DVec3 = Vec3Of<D>;
  const DVec3 u = Fixed<D>(a.along), v = Moving(b.along, false);
  const DVec3 w = Moving(b.start, true) - Fixed<D>(a.start);
  const DVec3 c = Cross(u, v);
  const D q = Dot(c, c), scale = outwards / Sqrt(q);
  const D at_a = Dot(Cross(w, v), c) / q, at_b = Dot(Cross(w, u), c) / q;
  const D d = -(scale * Dot(w, c));
  const D ends = kEndWindow * r;
  D W = SmoothStep(at_a / ends) * SmoothStep((a.length - at_a) / ends) * SmoothStep(at_b / ends) *
        SmoothStep((b.length - at_b) / ends) * SmoothStep(q / kParallelWindow) *
        (1 - SmoothStep((d - kDepthFull * r) / ((kDepthGone - kDepthFull) * r)));
  for (int i = 0; i < 2; ++i) {
    W = W * SmoothStep(-(scale * Dot(c, Fixed<D>(a.into[i]))) / kConeWindow) *
        SmoothStep(scale * Dot(c, Moving(b.into[i], false)) / kConeWindow);
  }
  return {Power(d, exponent + 2) * W, d, at_a, at_b};
}

// An axis that is clearly not along this one.
inline Vec3 AxisAcross(const Vec3& axis) {
  return std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
}

}  // namespace contact_toolkit
