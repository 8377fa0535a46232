// Six-dimensional linear algebra of rigid motions: rotation, or torque, comes first.
#pragma once

#include <array>

#include "math/vec.h"

namespace contact_toolkit {

// A number's change by a small motion: rotation · θ + translation · t, with θ [rad] and t [m] of a
// frame's origin.
struct Slope {
  Vec3 rotation, translation;

  Slope& operator+=(const Slope& b) {
    rotation += b.rotation, translation += b.translation;
    return *this;
  }
};

inline Slope operator+(const Slope& a, const Slope& b) {
  return {a.rotation + b.rotation, a.translation + b.translation};
}
inline Slope operator*(double s, const Slope& a) { return {s * a.rotation, s * a.translation}; }

// A vector's change by a small motion, column by column: by θ, then by t.
using VectorSlope = std::array<Vec3, 6>;

struct Mat6 {
  double m[6][6] = {};

  double* operator[](int row) { return m[row]; }
  const double* operator[](int row) const { return m[row]; }
};

}  // namespace contact_toolkit
