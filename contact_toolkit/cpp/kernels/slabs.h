// The slabs of nodes against the boxes of others, lane by lane. Included by one source file per
// instruction set, inside an unnamed namespace.
#pragma once

#include <cstdint>

#include "kernels/lanes.h"
#include "shapes/bvh.h"

namespace contact_toolkit {
namespace {

// Bits of the lanes that hold children.
CT_INLINE std::uint64_t LanesUsed(int count) { return (std::uint64_t{1} << count) - 1; }

// The slabs of a and of b, posed by R and p in the frame of A's boxes, against the boxes of the
// other.
struct PosedSlabs {
  Float8 reach_b[3];                         // |normals of a| along the axes of B
  Float8 thick_a;                            // half, of a's slabs
  alignas(32) float normal[3][8], place[8];  // of b's slabs in A
  alignas(32) float thick_b[8];

  CT_INLINE PosedSlabs(const BvhNode& a, const BvhNode& b, const float (&R)[3][3],
                       const float (&p)[3])
      : thick_a(Load8(a.thick)) {
    Float8 at = Load8(b.middle);
    for (int i = 0; i < 3; ++i) {
      Float8 n{}, turned{};
      for (int k = 0; k < 3; ++k) {
        n = n + R[i][k] * Load8(b.normal[k]);
        turned = turned + R[k][i] * Load8(a.normal[k]);
      }
      Store8(normal[i], n);
      reach_b[i] = Absolute(turned);
      at = at + p[i] * n;
    }
    Store8(place, at);
    Store8(thick_b, Load8(b.thick));
  }

  // Takes in what they sweep over when B goes by up to `way` in A to either side.
  CT_INLINE void Sweep(const BvhNode& a, const float (&way)[3]) {
    Float8 along_a{}, along_b{};
    for (int i = 0; i < 3; ++i) {
      along_a = along_a + way[i] * Load8(a.normal[i]);
      along_b = along_b + way[i] * Load8(normal[i]);
    }
    thick_a = thick_a + Absolute(along_a);
    Store8(thick_b, Load8(thick_b) + Absolute(along_b));
  }

  // How far, at least, the children of a are from child j of b, the centres of whose boxes are
  // given in A.
  CT_INLINE Float8 Gaps(const BvhNode& a, const BvhNode& b, const float (&center)[3][8], int j,
                        float slack) const {
    Float8 from_a = -Load8(a.middle), reach_a = thick_a;
    Float8 from_b = Fill8(-place[j]), reach_of_b = Fill8(thick_b[j]);
    for (int i = 0; i < 3; ++i) {
      from_a = from_a + Load8(a.normal[i]) * center[i][j];
      reach_a = reach_a + reach_b[i] * b.half[i][j];
      const float n = normal[i][j];
      from_b = from_b + n * Load8(a.center[i]);
      reach_of_b = reach_of_b + (n < 0 ? -n : n) * Load8(a.half[i]);
    }
    return Most(Absolute(from_a) - reach_a, Absolute(from_b) - reach_of_b) - slack;
  }
};

}  // namespace
}  // namespace contact_toolkit
