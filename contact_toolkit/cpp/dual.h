// Forward-mode differentiation: a number with its derivatives along the six directions of a rigid
// motion (three translations, then three rotations).
#pragma once

#include <array>
#include <cmath>

namespace contact_toolkit {

struct Dual {
  double value = 0;
  std::array<double, 6> slope{};

  Dual() = default;
  Dual(double x) : value(x) {}  // NOLINT(google-explicit-constructor): constants mix with duals
};

// f(a) where f has the value `value` and the derivative `slope` at a.
inline Dual Chain(const Dual& a, double value, double slope) {
  Dual r(value);
  for (int i = 0; i < 6; ++i) r.slope[i] = slope * a.slope[i];
  return r;
}
inline Dual operator-(const Dual& a) { return Chain(a, -a.value, -1); }
inline Dual operator+(const Dual& a, const Dual& b) {
  Dual r(a.value + b.value);
  for (int i = 0; i < 6; ++i) r.slope[i] = a.slope[i] + b.slope[i];
  return r;
}
inline Dual operator-(const Dual& a, const Dual& b) { return a + -b; }
inline Dual operator*(const Dual& a, const Dual& b) {
  Dual r(a.value * b.value);
  for (int i = 0; i < 6; ++i) r.slope[i] = a.slope[i] * b.value + a.value * b.slope[i];
  return r;
}
inline Dual operator/(const Dual& a, const Dual& b) {
  return a * Chain(b, 1 / b.value, -1 / (b.value * b.value));
}
inline Dual Sqrt(const Dual& a) {
  const double root = std::sqrt(a.value);
  return Chain(a, root, 0.5 / root);
}
inline Dual Power(const Dual& a, double n) {
  const double power = std::pow(a.value, n - 1);
  return Chain(a, a.value * power, n * power);
}

struct DualVec3 {
  Dual x, y, z;
};

inline DualVec3 operator-(const DualVec3& a, const DualVec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Dual Dot(const DualVec3& a, const DualVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline DualVec3 Cross(const DualVec3& a, const DualVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace contact_toolkit
