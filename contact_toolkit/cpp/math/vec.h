// Small fixed-size linear algebra, by value. Monogram names: X_AB is the pose of frame B in frame
// A, p_AB_A a position from Ao to Bo expressed in A.
#pragma once

#include <array>
#include <cmath>

namespace contact_toolkit {

struct Vec3 {
  double x = 0, y = 0, z = 0;

  double& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  Vec3& operator+=(const Vec3& b) {
    x += b.x, y += b.y, z += b.z;
    return *this;
  }
  Vec3& operator-=(const Vec3& b) {
    x -= b.x, y -= b.y, z -= b.z;
    return *this;
  }
  bool operator==(const Vec3&) const = default;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Vec3 operator*(const Vec3& a, double s) { return s * a; }
inline Vec3 operator/(const Vec3& a, double s) { return {a.x / s, a.y / s, a.z / s}; }
inline double Dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double SquaredNorm(const Vec3& a) { return Dot(a, a); }
inline double Norm(const Vec3& a) { return std::sqrt(SquaredNorm(a)); }
// The unit vector along a, or zero when a is zero.
inline Vec3 Normalized(const Vec3& a) {
  const double norm = Norm(a);
  return norm > 0 ? a / norm : Vec3{};
}

struct Mat3 {
  std::array<Vec3, 3> row{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
};

inline Vec3 operator*(const Mat3& m, const Vec3& a) {
  return {Dot(m.row[0], a), Dot(m.row[1], a), Dot(m.row[2], a)};
}
inline Mat3 Transpose(const Mat3& m) {
  return {{Vec3{m.row[0].x, m.row[1].x, m.row[2].x}, Vec3{m.row[0].y, m.row[1].y, m.row[2].y},
           Vec3{m.row[0].z, m.row[1].z, m.row[2].z}}};
}
inline Mat3 operator*(const Mat3& a, const Mat3& b) {
  const Mat3 bt = Transpose(b);
  Mat3 c;
  for (int i = 0; i < 3; ++i) c.row[i] = bt * a.row[i];
  return c;
}

// A rigid transform: R_AB is a rotation, p_AB the position of Bo from Ao in A.
struct Pose {
  Mat3 R;
  Vec3 p;

  // From 16 row-major numbers of a homogeneous matrix.
  static Pose FromMatrix(const double* m) {
    return {{{Vec3{m[0], m[1], m[2]}, Vec3{m[4], m[5], m[6]}, Vec3{m[8], m[9], m[10]}}},
            {m[3], m[7], m[11]}};
  }
};

inline Vec3 operator*(const Pose& X_AB, const Vec3& p_BQ) { return X_AB.R * p_BQ + X_AB.p; }
inline Pose operator*(const Pose& X_AB, const Pose& X_BC) {
  return {X_AB.R * X_BC.R, X_AB * X_BC.p};
}
inline Pose Inverse(const Pose& X_AB) {
  const Mat3 R_BA = Transpose(X_AB.R);
  return {R_BA, -(R_BA * X_AB.p)};
}

}  // namespace contact_toolkit
