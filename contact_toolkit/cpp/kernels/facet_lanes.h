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

// Loads lane-wise: entry (corner, axis) of each lane's facet.
template <class V, int lanes>
CT_INLINE void LoadFacets(const double* coordinates, const std::int32_t* slots, Vec<V> (&P)[3]) {
  for (int c = 0; c < 3; ++c) {
    alignas(64) double x[lanes], y[lanes], z[lanes];
    for (int k = 0; k < lanes; ++k) {
      const double* p = coordinates + 9 * static_cast<std::int64_t>(slots[k]) + 3 * c;
      x[k] = p[0], y[k] = p[1], z[k] = p[2];
    }
    Load(x, &P[c].x);
    Load(y, &P[c].y);
    Load(z, &P[c].z);
  }
}

}  // namespace
}  // namespace contact_toolkit
