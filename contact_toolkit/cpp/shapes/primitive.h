// Shapes whose signed distance has a closed form. A mesh that stands for one may carry it along, so
// that what touches it meets the true surface.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "math/vec.h"

namespace contact_toolkit {

struct Primitive {
  enum class Kind { kNone, kSphere, kCapsule, kCylinder, kBox, kHalfSpace };

  Kind kind = Kind::kNone;
  Vec3 size;  // [m] sphere: radius; capsule, cylinder: radius and length about z; box: edge
              // lengths; half space z < 0: none

  explicit operator bool() const { return kind != Kind::kNone; }
  // [m] The least radius of curvature of a round one; 0 of one that is not.
  double roundness() const {
    return kind == Kind::kSphere || kind == Kind::kCapsule || kind == Kind::kCylinder ? size.x : 0;
  }

  // Whether the mesh's flat sides may be its own.
  bool has_flat_sides() const { return kind != Kind::kSphere && kind != Kind::kCapsule; }

  struct Distance {
    double phi;     // [m] negative inside
    Vec3 gradient;  // unit; where several features are equally close, that of one of them
  };
  Distance At(const Vec3& p) const;
  // [m] Nowhere in a triangle is phi less: of a convex body it is a convex function, so it lies
  // above its tangent at p.
  double LeastOver(const std::array<Vec3, 3>& corners, const Vec3& p) const;
  // [1/m] Its second derivatives: xx, yy, zz, xy, xz, yz.
  std::array<double, 6> CurvatureAt(const Vec3& p) const;

 private:
  static Distance FromPoint(const Vec3& offset, double radius) {
    const double away = Norm(offset);
    return {away - radius, away > 0 ? offset / away : Vec3{0, 0, 1}};
  }
  // Of something whose sides are at `excess` along unit vectors square to each other.
  template <int n>
  static Distance FromSides(const double (&excess)[n], const Vec3 (&outwards)[n]) {
    int most = 0, outside = 0;
    double squared = 0;
    Vec3 sum;
    for (int i = 0; i < n; ++i) {
      if (excess[i] > excess[most]) most = i;
      if (!(excess[i] > 0)) continue;
      ++outside;
      squared += excess[i] * excess[i];
      sum += excess[i] * outwards[i];
    }
    if (outside < 2) return {excess[most], outwards[most]};
    const double away = std::sqrt(squared);
    return {away, sum / away};
  }
};

inline Primitive::Distance Primitive::At(const Vec3& p) const {
  switch (kind) {
    case Kind::kSphere:
      return FromPoint(p, size.x);
    case Kind::kCapsule: {
      const double half = 0.5 * size.y;
      return FromPoint({p.x, p.y, p.z - std::clamp(p.z, -half, half)}, size.x);
    }
    case Kind::kCylinder: {
      const double away = std::sqrt(p.x * p.x + p.y * p.y);
      const Vec3 radial = away > 0 ? Vec3{p.x / away, p.y / away, 0} : Vec3{1, 0, 0};
      return FromSides<2>({away - size.x, std::abs(p.z) - 0.5 * size.y},
                          {radial, Vec3{0, 0, p.z < 0 ? -1.0 : 1.0}});
    }
    case Kind::kBox:
      return FromSides<3>({std::abs(p.x) - 0.5 * size.x, std::abs(p.y) - 0.5 * size.y,
                           std::abs(p.z) - 0.5 * size.z},
                          {Vec3{p.x < 0 ? -1.0 : 1.0, 0, 0}, Vec3{0, p.y < 0 ? -1.0 : 1.0, 0},
                           Vec3{0, 0, p.z < 0 ? -1.0 : 1.0}});
    default:
      return {p.z, {0, 0, 1}};
  }
}

inline double Primitive::LeastOver(const std::array<Vec3, 3>& corners, const Vec3& p) const {
  const auto [phi, gradient] = At(p);
  const auto rise = [&, g = gradient](const Vec3& corner) { return Dot(g, corner - p); };
  return phi + std::min({rise(corners[0]), rise(corners[1]), rise(corners[2])});
}

inline std::array<double, 6> Primitive::CurvatureAt(const Vec3& p) const {
  std::array<double, 6> sum{};
  const auto add = [&](double k, const Vec3& u) {
    sum[0] += k * u.x * u.x, sum[1] += k * u.y * u.y, sum[2] += k * u.z * u.z;
    sum[3] += k * u.x * u.y, sum[4] += k * u.x * u.z, sum[5] += k * u.y * u.z;
  };
  const auto [phi, g] = At(p);
  const double around = std::sqrt(p.x * p.x + p.y * p.y);  // from the axis
  const Vec3 along = around > 0 ? Vec3{-p.y / around, p.x / around, 0} : Vec3{0, 1, 0};
  const auto add_round = [&, g = g](double k, bool x, bool y, bool z) {  // in some axes, about g
    if (x) add(k, {1, 0, 0});
    if (y) add(k, {0, 1, 0});
    if (z) add(k, {0, 0, 1});
    add(-k, g);
  };
  const bool ended = kind == Kind::kCapsule && std::abs(p.z) > 0.5 * size.y;
  switch (kind) {
    case Kind::kSphere:
    case Kind::kCapsule:
      if (!(phi + size.x > 0)) break;
      if (kind == Kind::kSphere || ended) {
        add_round(1 / (phi + size.x), true, true, true);
      } else {
        add(1 / around, along);
      }
      break;
    case Kind::kCylinder: {
      const double radial = std::sqrt(g.x * g.x + g.y * g.y);
      if (radial > 0 && around > 0) add(radial / around, along);
      // About the rim.
      if (radial > 0 && g.z != 0) add(1 / phi, {-g.z * along.y, g.z * along.x, radial});
      break;
    }
    case Kind::kBox:
      if ((g.x != 0) + (g.y != 0) + (g.z != 0) > 1)
        add_round(1 / phi, g.x != 0, g.y != 0, g.z != 0);
      break;
    default:
      break;
  }
  return sum;
}

}  // namespace contact_toolkit
