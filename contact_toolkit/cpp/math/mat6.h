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

inline Slope operator*(const Mat6& m, const Slope& x) {
  const double in[6] = {x.rotation.x,    x.rotation.y,    x.rotation.z,
                        x.translation.x, x.translation.y, x.translation.z};
  double out[6] = {};
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) out[i] += m[i][k] * in[k];
  }
  return {{out[0], out[1], out[2]}, {out[3], out[4], out[5]}};
}

// R m Rᵀ on each of the four quarters.
inline Mat6 Turned(const Mat3& R, const Mat6& m) {
  Mat6 half, turned;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const int first = i / 3 * 3;
      for (int k = 0; k < 3; ++k) half.m[i][j] += R.row[i - first][k] * m.m[first + k][j];
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const int first = j / 3 * 3;
      for (int k = 0; k < 3; ++k) turned.m[i][j] += half.m[i][first + k] * R.row[j - first][k];
    }
  }
  return turned;
}

}  // namespace contact_toolkit
