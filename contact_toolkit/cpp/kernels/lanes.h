// Vectors of doubles or floats by compiler extension, and the few operations they lack. A lane type
// of one is plain double, so that the kernels' source is the same for all widths. Everything is in
// an unnamed namespace: each instruction set must get code of its own.
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>

namespace contact_toolkit {
namespace {

template <int n>
struct LanesOf {
  typedef double Type __attribute__((vector_size(8 * n)));
  typedef float Single __attribute__((vector_size(4 * n)));
};
template <>
struct LanesOf<1> {
  using Type = double;
  using Single = float;
};

using Float8 = float __attribute__((vector_size(32)));
using Mask8 = std::int32_t __attribute__((vector_size(32)));

#define CT_INLINE inline __attribute__((always_inline))
// Before loops over corners and edges: left rolled up, they keep vectors in memory.
#if defined(__clang__)
#define CT_UNROLL _Pragma("clang loop unroll(full)")
#else
#define CT_UNROLL _Pragma("GCC unroll 6")
#endif

#if defined(__AVX512F__)
// One instruction each, which GCC and Clang name differently; 4: rounding as the thread has it.
#if defined(__clang__)
#define CT_LEAST512(t, a, b) __builtin_ia32_min##t##512(a, b, 4)
#define CT_MOST512(t, a, b) __builtin_ia32_max##t##512(a, b, 4)
#define CT_ROOT512(a) __builtin_ia32_sqrtpd512(a, 4)
#define CT_INVERSE512(a) __builtin_ia32_rcp14ps512_mask(a, a, -1)
#else
#define CT_LEAST512(t, a, b) __builtin_ia32_min##t##512_mask(a, b, a, -1, 4)
#define CT_MOST512(t, a, b) __builtin_ia32_max##t##512_mask(a, b, a, -1, 4)
#define CT_ROOT512(a) __builtin_ia32_sqrtpd512_mask(a, a, -1, 4)
#define CT_INVERSE512(a) __builtin_ia32_rcp14ps512_mask(a, a, -1)
#endif
#endif

CT_INLINE double Select(bool mask, double a, double b) { return mask ? a : b; }
CT_INLINE long double Select(bool mask, long double a, long double b) { return mask ? a : b; }
template <class M, class V>
CT_INLINE V Select(M mask, V a, V b) {
  return mask ? a : b;
}
// As the processors' own instructions have it: the second operand where the comparison is false.
template <class V>
CT_INLINE V Least(V a, V b) {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(a[0]) == 8) return CT_LEAST512(pd, a, b);
  if constexpr (sizeof(V) == 64 && sizeof(a[0]) == 4) return CT_LEAST512(ps, a, b);
#endif
#if defined(__AVX__)
  if constexpr (sizeof(V) == 32 && sizeof(a[0]) == 8) return __builtin_ia32_minpd256(a, b);
  if constexpr (sizeof(V) == 32 && sizeof(a[0]) == 4) return __builtin_ia32_minps256(a, b);
#endif
  return Select(a < b, a, b);
}
template <class V>
CT_INLINE V Most(V a, V b) {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(a[0]) == 8) return CT_MOST512(pd, a, b);
  if constexpr (sizeof(V) == 64 && sizeof(a[0]) == 4) return CT_MOST512(ps, a, b);
#endif
#if defined(__AVX__)
  if constexpr (sizeof(V) == 32 && sizeof(a[0]) == 8) return __builtin_ia32_maxpd256(a, b);
  if constexpr (sizeof(V) == 32 && sizeof(a[0]) == 4) return __builtin_ia32_maxps256(a, b);
#endif
  return Select(a > b, a, b);
}
// Lane by lane to another precision.
template <class To>
CT_INLINE To Converted(double a) {
  return static_cast<To>(a);
}
template <class To>
CT_INLINE To Converted(float a) {
  return static_cast<To>(a);
}
template <class To, class V>
CT_INLINE To Converted(V a) {
  return __builtin_convertvector(a, To);
}
CT_INLINE float Least(float a, float b) { return a < b ? a : b; }
CT_INLINE double Least(double a, double b) { return a < b ? a : b; }
CT_INLINE double Most(double a, double b) { return a > b ? a : b; }
CT_INLINE long double Least(long double a, long double b) { return a < b ? a : b; }
CT_INLINE long double Most(long double a, long double b) { return a > b ? a : b; }
template <class V>
CT_INLINE V Absolute(V a) {
  return Select(a < V{}, -a, a);
}
CT_INLINE double SquareRoot(double a) { return __builtin_sqrt(a); }
CT_INLINE Float8 SquareRoot(Float8 a) {
#if defined(__AVX__)
  return __builtin_ia32_sqrtps256(a);
#else
  for (int k = 0; k < 8; ++k) a[k] = __builtin_sqrtf(a[k]);
  return a;
#endif
}
CT_INLINE long double SquareRoot(long double a) { return __builtin_sqrtl(a); }
template <class V>
CT_INLINE V SquareRoot(V a) {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64) return CT_ROOT512(a);
#endif
#if defined(__AVX__)
  if constexpr (sizeof(V) == 32) return __builtin_ia32_sqrtpd256(a);
#endif
  for (unsigned k = 0; k < sizeof(V) / sizeof(double); ++k) a[k] = __builtin_sqrt(a[k]);
  return a;
}
// Whether V is of floats.
template <class V>
constexpr bool IsSingle() {
  if constexpr (std::is_arithmetic_v<V>) {
    return false;
  } else {
    return sizeof(std::declval<V&>()[0]) == sizeof(float);
  }
}
// All lanes equal to x.
template <class V>
CT_INLINE V Fill(double x) {
  if constexpr (IsSingle<V>()) {
    return V{} + static_cast<float>(x);
  } else {
    return V{} + x;
  }
}
// 1 / a, to three digits at least, and not the same on all processors; of zero, infinity.
template <class V>
CT_INLINE V RoughInverse(V a) {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64) return CT_INVERSE512(a);
#endif
#if defined(__AVX__)
  if constexpr (sizeof(V) == 32) return __builtin_ia32_rcpps256(a);
#endif
  return Fill<V>(1) / a;
}
CT_INLINE Float8 Fill8(float x) { return Float8{} + x; }

CT_INLINE Float8 Load8(const float* p) {
  Float8 v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
CT_INLINE void Store8(float* p, Float8 v) { __builtin_memcpy(p, &v, sizeof v); }

// Bit k is set where lane k of a comparison holds.
CT_INLINE std::uint64_t Bits(Mask8 mask) {
#if defined(__AVX2__)
  return static_cast<std::uint32_t>(__builtin_ia32_movmskps256(reinterpret_cast<Float8>(mask)));
#else
  std::uint64_t bits = 0;
  for (int k = 0; k < 8; ++k) bits |= static_cast<std::uint64_t>(mask[k] & 1) << k;
  return bits;
#endif
}

// Whether a comparison holds in any lane.
CT_INLINE bool Any(bool mask) { return mask; }
CT_INLINE bool Any(int mask) { return mask != 0; }
template <class M>
CT_INLINE bool Any(M mask) {
#if defined(__AVX512DQ__)
  if constexpr (sizeof(M) == 64 && sizeof(mask[0]) == 8) {
    using Eight = long long __attribute__((vector_size(64)));
    return __builtin_ia32_cvtq2mask512(reinterpret_cast<Eight>(mask)) != 0;
  }
  if constexpr (sizeof(M) == 64 && sizeof(mask[0]) == 4) {
    using Sixteen = int __attribute__((vector_size(64)));
    return __builtin_ia32_cvtd2mask512(reinterpret_cast<Sixteen>(mask)) != 0;
  }
#endif
#if defined(__AVX__)
  using Four = double __attribute__((vector_size(32)));
  if constexpr (sizeof(M) == 32 && sizeof(mask[0]) == 4) {
    return __builtin_ia32_movmskps256(reinterpret_cast<Float8>(mask)) != 0;
  } else if constexpr (sizeof(M) == 32) {
    return __builtin_ia32_movmskpd256(reinterpret_cast<Four>(mask)) != 0;
  }
#endif
  bool any = false;
  for (unsigned k = 0; k < sizeof(M) / sizeof(mask[0]); ++k) any = any || mask[k] != 0;
  return any;
}

template <class V>
struct Vec {
  V x, y, z;
};
template <class V>
CT_INLINE Vec<V> operator-(const Vec<V>& a, const Vec<V>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class V>
CT_INLINE Vec<V> operator-(const Vec<V>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class V>
CT_INLINE Vec<V> operator+(const Vec<V>& a, const Vec<V>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class V>
CT_INLINE Vec<V> operator*(V s, const Vec<V>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class V>
CT_INLINE V Dot(const Vec<V>& a, const Vec<V>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class V>
CT_INLINE Vec<V> Cross(const Vec<V>& a, const Vec<V>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class M, class V>
CT_INLINE Vec<V> Select(M mask, const Vec<V>& a, const Vec<V>& b) {
  return {Select(mask, a.x, b.x), Select(mask, a.y, b.y), Select(mask, a.z, b.z)};
}

}  // namespace
}  // namespace contact_toolkit
