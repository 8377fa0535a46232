// Facets and poses in lanes of doubles. Included by one source file per instruction set, inside an
// unnamed namespace.
#pragma once

#include <cstdint>

#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

template <class V>
CT_INLINE void Store(double* to, V value) {
  __builtin_memcpy(to, &value, sizeof value);
}
CT_INLINE void Store(double* to, long double value) { *to = static_cast<double>(value); }

template <class V>
CT_INLINE void Load(const double* from, V* value) {
  __builtin_memcpy(value, from, sizeof *value);
}
CT_INLINE void Load(const double* from, long double* value) { *value = *from; }

// X: row-major rotation, then translation.
template <class V>
CT_INLINE Vec<V> Posed(const double* X, const Vec<V>& p) {
  return {X[0] * p.x + X[1] * p.y + X[2] * p.z + X[9], X[3] * p.x + X[4] * p.y + X[5] * p.z + X[10],
          X[6] * p.x + X[7] * p.y + X[8] * p.z + X[11]};
}

// Four rows of four numbers, or two such blocks side by side: rows become columns.
template <class V>
CT_INLINE void Transpose(V (&row)[4]) {
  const V &a = row[0], &b = row[1], &c = row[2], &d = row[3];
  if constexpr (sizeof(V) == 64) {
    const V ab0 = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    const V ab1 = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
    const V cd0 = __builtin_shufflevector(c, d, 0, 8, 2, 10, 4, 12, 6, 14);
    const V cd1 = __builtin_shufflevector(c, d, 1, 9, 3, 11, 5, 13, 7, 15);
    row[0] = __builtin_shufflevector(ab0, cd0, 0, 1, 8, 9, 4, 5, 12, 13);
    row[1] = __builtin_shufflevector(ab1, cd1, 0, 1, 8, 9, 4, 5, 12, 13);
    row[2] = __builtin_shufflevector(ab0, cd0, 2, 3, 10, 11, 6, 7, 14, 15);
    row[3] = __builtin_shufflevector(ab1, cd1, 2, 3, 10, 11, 6, 7, 14, 15);
  } else {
    const V ab0 = __builtin_shufflevector(a, b, 0, 4, 2, 6);
    const V ab1 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const V cd0 = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const V cd1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    row[0] = __builtin_shufflevector(ab0, cd0, 0, 1, 4, 5);
    row[1] = __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5);
    row[2] = __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7);
    row[3] = __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7);
  }
}

// Loads lane-wise: entry (corner, axis) of each lane's facet.
template <class V, int lanes>
CT_INLINE void LoadFacets(const double* coordinates, const std::int32_t* slots, Vec<V> (&P)[3]) {
  V* to[9] = {&P[0].x, &P[0].y, &P[0].z, &P[1].x, &P[1].y, &P[1].z, &P[2].x, &P[2].y, &P[2].z};
  const auto facet = [&](int lane) {
    return coordinates + 9 * static_cast<std::int64_t>(slots[lane]);
  };
  int next = 0;
  if constexpr (lanes >= 4) {
    // Four numbers of each facet at a time.
    CT_UNROLL
    for (; next < 8; next += 4) {
      V row[4];
      CT_UNROLL
      for (int k = 0; k < 4; ++k) {
        if constexpr (lanes == 8) {
          typename LanesOf<4>::Type low, high;
          Load(facet(k) + next, &low);
          Load(facet(k + 4) + next, &high);
          row[k] = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
        } else {
          Load(facet(k) + next, &row[k]);
        }
      }
      Transpose(row);
      CT_UNROLL
      for (int k = 0; k < 4; ++k) *to[next + k] = row[k];
    }
  }
  for (; next < 9; ++next) {
    alignas(64) double x[lanes];
    for (int k = 0; k < lanes; ++k) x[k] = facet(k)[next];
    Load(x, to[next]);
  }
}

}  // namespace
}  // namespace contact_toolkit
