// Forward-mode differentiation: a number with its derivatives along the six directions of a rigid
// motion (three translations, then three rotations). Of what kind the numbers are is open: duals of
// duals have second derivatives.
#pragma once

#include <array>
#include <cmath>
#include <type_traits>

namespace contact_toolkit {

inline double Sqrt(double a) { return std::sqrt(a); }
inline double Power(double a, double n) { return std::pow(a, n); }

template <class T>
struct DualOf {
  T value{};
  std::array<T, 6> slope{};

  DualOf() = default;
  DualOf(T x) : value(x) {}  // NOLINT(google-explicit-constructor): constants mix with duals
  template <class Number>
    requires(std::is_arithmetic_v<Number> && !std::is_same_v<T, Number>)
  DualOf(Number x) : value(x) {}  // NOLINT(google-explicit-constructor): likewise

  // f(a) where f has the value `value` and the derivative `slope` at a.
  friend DualOf Chain(const DualOf& a, const T& value, const T& slope) {
    DualOf r(value);
    for (int i = 0; i < 6; ++i) r.slope[i] = slope * a.slope[i];
    return r;
  }
  friend DualOf operator-(const DualOf& a) { return Chain(a, -a.value, -1.0); }
  friend DualOf operator+(const DualOf& a, const DualOf& b) {
    DualOf r(a.value + b.value);
    for (int i = 0; i < 6; ++i) r.slope[i] = a.slope[i] + b.slope[i];
    return r;
  }
  friend DualOf operator-(const DualOf& a, const DualOf& b) { return a + -b; }
  friend DualOf operator*(const DualOf& a, const DualOf& b) {
    DualOf r(a.value * b.value);
    for (int i = 0; i < 6; ++i) r.slope[i] = a.slope[i] * b.value + a.value * b.slope[i];
    return r;
  }
  friend DualOf operator/(const DualOf& a, const DualOf& b) {
    return a * Chain(b, 1.0 / b.value, -1.0 / (b.value * b.value));
  }
  friend DualOf Sqrt(const DualOf& a) {
    const T root = Sqrt(a.value);
    return Chain(a, root, 0.5 / root);
  }
  friend DualOf Power(const DualOf& a, double n) {
    const T power = Power(a.value, n - 1);
    return Chain(a, a.value * power, n * power);
  }
};

using Dual = DualOf<double>;

// The plain number.
inline double Plain(double a) { return a; }
template <class T>
double Plain(const DualOf<T>& a) {
  return Plain(a.value);
}

template <class Number>
struct Vec3Of {
  Number x, y, z;
};
using DualVec3 = Vec3Of<Dual>;

template <class T>
Vec3Of<T> operator+(const Vec3Of<T>& a, const Vec3Of<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
Vec3Of<T> operator-(const Vec3Of<T>& a, const Vec3Of<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
Vec3Of<T> operator*(const T& s, const Vec3Of<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
T Dot(const Vec3Of<T>& a, const Vec3Of<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Vec3Of<T> Cross(const Vec3Of<T>& a, const Vec3Of<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace contact_toolkit
