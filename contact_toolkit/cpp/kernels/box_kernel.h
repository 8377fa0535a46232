// Culling in single precision: eight boxes or facets of A against those of B, one by one. Included
// by one source file per instruction set, inside an unnamed namespace.
#pragma once

#include "base/tolerances.h"
#include "kernels/facet_cull.h"
#include "kernels/kernels.h"
#include "kernels/lanes.h"
#include "kernels/slabs.h"

namespace contact_toolkit {
namespace {

// The boxes of b in A: centres, and half extents of the boxes around the turned boxes.
struct PosedBoxes {
  alignas(32) float center[3][8], half[3][8];

  CT_INLINE PosedBoxes(const BvhNode& b, const CullPose& X) {
    for (int i = 0; i < 3; ++i) {
      Float8 c = Fill8(X.p[i]), h = Fill8(X.slack);
      for (int k = 0; k < 3; ++k) {
        c = c + X.R[i][k] * Load8(b.center[k]);
        h = h + X.abs_R[i][k] * Load8(b.half[k]);
      }
      Store8(center[i], c);
      Store8(half[i], h);
    }
  }

  // From box j to all boxes of a, middle to middle.
  CT_INLINE void Offsets(const BvhNode& a, int j, Float8 (&offset)[3]) const {
    for (int i = 0; i < 3; ++i) offset[i] = Load8(a.center[i]) - center[i][j];
  }

  // The squared lower bounds of the distances of box j from all boxes of a.
  CT_INLINE Float8 Squared(const BvhNode& a, int j, const Float8 (&offset)[3]) const {
    Float8 squared{};
    for (int i = 0; i < 3; ++i) {
      const Float8 gap = Most(Absolute(offset[i]) - Load8(a.half[i]) - half[i][j], Float8{});
      squared = squared + gap * gap;
    }
    return squared;
  }
};

std::uint64_t BoxPairs(const BvhNode& a, const BvhNode& b, const CullPose& X_AB, float reach) {
  std::uint64_t pairs = 0;
  const Float8 most = Fill8(reach * reach * (1 + kBoundRounding));
  const PosedBoxes boxes(b, X_AB);
  for (int j = 0; j < b.count; ++j) {
    Float8 offset[3];
    boxes.Offsets(a, j, offset);
    pairs |= (Bits(boxes.Squared(a, j, offset) <= most) & LanesUsed(a.count)) << (8 * j);
  }
  // Facets will be compared along their normals anyway.
  if (pairs == 0 || (a.bottom() && b.bottom())) return pairs;
  const PosedSlabs slabs(a, b, X_AB.R, X_AB.p);
  const Float8 limit = Fill8(reach * (1 + kBoundRounding));
  std::uint64_t near = 0;
  for (int j = 0; j < b.count; ++j) {
    if ((pairs >> (8 * j) & 0xff) == 0) continue;
    near |= Bits(slabs.Gaps(a, b, boxes.center, j, X_AB.slack) <= limit) << (8 * j);
  }
  return pairs & near;
}

// Calls visit(j, squared lower bounds, offsets of the middles) for each child j of b. Slabs are
// looked at where boxes are within the squared limit, and no farther away than they are large:
// beyond, they tell nothing new. Returns the bits (8 j + k) of those within the limit.
template <class Visit>
CT_INLINE std::uint64_t ForBounds(const BvhNode& a, const BvhNode& b, const CullPose& X,
                                  float limit, Visit visit) {
  const PosedBoxes boxes(b, X);
  const PosedSlabs slabs(a, b, X.R, X.p);
  std::uint64_t near = 0;
  for (int j = 0; j < b.count; ++j) {
    Float8 offset[3];
    boxes.Offsets(a, j, offset);
    Float8 squared = boxes.Squared(a, j, offset);
    const float size = boxes.half[0][j] + boxes.half[1][j] + boxes.half[2][j];
    const float close = Least(limit, size * size);
    if ((Bits(squared <= Fill8(close)) & LanesUsed(a.count)) != 0) {
      const Float8 gap = Most(slabs.Gaps(a, b, boxes.center, j, X.slack), Float8{});
      squared = Most(gap * gap, squared);
    }
    squared = squared * (1 - kBoundRounding);
    near |= (Bits(squared <= Fill8(limit)) & LanesUsed(a.count)) << (8 * j);
    visit(j, squared, offset);
  }
  return near;
}

std::uint64_t BoxBounds(const BvhNode& a, const BvhNode& b, const CullPose& X_AB, float limit,
                        float bound[64]) {
  return ForBounds(a, b, X_AB, limit, [&](int j, Float8 squared, const Float8(&)[3]) {
    Store8(bound + 8 * j, squared);
  });
}

std::uint64_t BoxOrders(const BvhNode& a, const BvhNode& b, const CullPose& X_AB, float limit,
                        float middles, float bound[64], float order[64]) {
  return ForBounds(a, b, X_AB, limit, [&](int j, Float8 squared, const Float8(&offset)[3]) {
    const Float8 apart = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
    Store8(bound + 8 * j, squared);
    Store8(order + 8 * j, squared + middles * apart);
  });
}

std::uint64_t CullByAxes(const FacetBlock& a, const FacetBlock& b, const CullPose& X, float reach,
                         std::uint64_t pairs) {
  return CullFacets<false>(a, b, X.R, X.p, {}, {}, reach * (1 + kBoundRounding) + X.slack, pairs);
}

}  // namespace
}  // namespace contact_toolkit
