// How the surface of a capsule or cylinder is sampled: nodes lie on the true surface, close
// together around it and far apart along it, as its contact with what is flat is narrow and long.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "math/vec.h"
#include "shapes/primitive.h"
#include "web/area/triangle_cut.h"

namespace contact_toolkit {

struct RoundLattice {
  Primitive shape;
  // [m] Between nodes around it, and on the ends of a capsule; 0: no such thing. And along it.
  double across = 0, along = 0;

  explicit operator bool() const { return across > 0; }

  // Not in one of the flat ends of a cylinder.
  bool IsRound(const Corners& t) const {
    if (!*this) return false;
    if (shape.kind != Primitive::Kind::kCylinder) return true;
    return std::abs(t[0].z + t[1].z + t[2].z) < 3 * (1 - kOnEnd) * Half();
  }

  // Of two points of the round surface.
  bool OnSide(const Vec3& a, const Vec3& b) const {
    return std::max(std::abs(a.z), std::abs(b.z)) <= (1 + kOnEnd) * Half();
  }

  bool OnSide(const Corners& t) const { return OnSide(t[0], t[1]) && OnSide(t[1], t[2]); }

  // Calls emit(part) for what replaces the mesh's facets along the side: cut in half until they are
  // narrow enough, they are short enough too. The facets are halves of rectangles; one of each pair
  // stands for both.
  template <typename Emit>
  void CutSide(const Corners& facet, const Emit& emit) const {
    int top = -1, num_above = 0;
    for (int k = 0; k < 3; ++k) {
      if (facet[k].z > 0) top = k, ++num_above;
    }
    if (num_above != 1) return;
    const Vec3 &a = facet[(top + 1) % 3], &b = facet[(top + 2) % 3];
    const double length = facet[top].z - a.z;
    const double halvings = std::max(0.0, std::ceil(std::log2(Norm(b - a) / across)));
    const int count = static_cast<int>(std::ceil(length / (along * std::exp2(halvings))));
    const auto at = [&](const Vec3& p, int i) { return Vec3{p.x, p.y, p.z + length * i / count}; };
    for (int i = 0; i < count; ++i) {
      emit(Corners{at(a, i), at(b, i), at(b, i + 1)});
      emit(Corners{at(a, i), at(b, i + 1), at(a, i + 1)});
    }
  }

  // The point of the round surface next to one a little beneath it.
  Vec3 Raised(const Vec3& p) const {
    if (OnSide(p, p)) {
      const double stretch = shape.size.x / std::sqrt(p.x * p.x + p.y * p.y);
      return {stretch * p.x, stretch * p.y, p.z};
    }
    const Vec3 middle{0, 0, std::copysign(Half(), p.z)};
    const Vec3 offset = p - middle;
    return middle + shape.size.x / Norm(offset) * offset;
  }

  // [m] By which the surface is farther out than a triangle of its points, on average: of
  // 1/2 Σ λ_i λ_j |e_ij|² / R, e the edges without what runs along the axis.
  double BulgeOver(const Corners& t) const {
    if (!IsRound(t)) return 0;
    const bool side = OnSide(t);
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 e = t[(k + 1) % 3] - t[k];
      sum += e.x * e.x + e.y * e.y + (side ? 0 : e.z * e.z);
    }
    return sum / (24 * shape.size.x);
  }
  // [m] Nowhere over it is the surface farther out: as Σ λ_i λ_j <= 1/3.
  double MostRise(const Corners& t) const { return 4 * BulgeOver(t); }
  double LargestBulge() const { return *this ? across * across / (8 * shape.size.x) : 0; }

 private:
  static constexpr double kOnEnd = 1e-9;  // [-] of the length: rounding of what lies at the ends

  double Half() const { return 0.5 * shape.size.y; }
};

}  // namespace contact_toolkit
