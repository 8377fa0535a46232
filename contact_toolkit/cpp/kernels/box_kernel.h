// Culling in single precision: eight boxes or facets of A against those of B, one by one. Included
// by one source file per instruction set, inside an unnamed namespace.
#pragma once

#include "kernels/kernels.h"
#include "kernels/lanes.h"
#include "kernels/separation.h"
#include "kernels/slabs.h"

namespace contact_toolkit {
namespace {

CT_INLINE std::uint64_t LanesUsed(int count) { return (std::uint64_t{1} << count) - 1; }

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
  const Float8 most = Fill8(reach * reach * 1.0001f);
  const PosedBoxes boxes(b, X_AB);
  for (int j = 0; j < b.count; ++j) {
    Float8 offset[3];
    boxes.Offsets(a, j, offset);
    pairs |= (Bits(boxes.Squared(a, j, offset) <= most) & LanesUsed(a.count)) << (8 * j);
  }
  // Facets will be compared along their normals anyway.
  if (pairs == 0 || (a.bottom() && b.bottom())) return pairs;
  const PosedSlabs slabs(a, b, X_AB.R, X_AB.p);
  const Float8 limit = Fill8(reach * 1.0001f);
  std::uint64_t near = 0;
  for (int j = 0; j < b.count; ++j) {
    if ((pairs >> (8 * j) & 0xff) == 0) continue;
    near |= Bits(slabs.Gaps(a, b, boxes.center, j, X_AB.slack) <= limit) << (8 * j);
  }
  return pairs & near;
}

// Calls visit(j, squared lower bounds, offsets of the middles) for each child j of b. Slabs are
// looked at where boxes are within the squared limit, and no farther away than they are large:
// beyond, they tell nothing new.
template <class Visit>
CT_INLINE void ForBounds(const BvhNode& a, const BvhNode& b, const CullPose& X, float limit,
                         Visit visit) {
  const PosedBoxes boxes(b, X);
  const PosedSlabs slabs(a, b, X.R, X.p);
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
    visit(j, squared * 0.9999f, offset);
  }
}

void BoxBounds(const BvhNode& a, const BvhNode& b, const CullPose& X_AB, float limit,
               float bound[64]) {
  ForBounds(a, b, X_AB, limit,
            [&](int j, Float8 squared, const Float8(&)[3]) { Store8(bound + 8 * j, squared); });
}

void BoxOrders(const BvhNode& a, const BvhNode& b, const CullPose& X_AB, float limit, float middles,
               float bound[64], float order[64]) {
  ForBounds(a, b, X_AB, limit, [&](int j, Float8 squared, const Float8(&offset)[3]) {
    const Float8 apart = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
    Store8(bound + 8 * j, squared);
    Store8(order + 8 * j, squared + middles * apart);
  });
}

std::uint64_t CullByAxes(const FacetBlock& a, const FacetBlock& b, const CullPose& X, float reach,
                         std::uint64_t pairs) {
  const float limit = reach * 1.0001f + X.slack;
  alignas(32) float corner[3][3][8], normal[3][8], offset[8];
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < 3; ++i) {
      Float8 v = Fill8(X.p[i]);
      for (int k = 0; k < 3; ++k) v = v + X.R[i][k] * Load8(b.vertex[c][k]);
      Store8(corner[c][i], v);
    }
  }
  Float8 shift{};
  for (int i = 0; i < 3; ++i) {
    Float8 n{};
    for (int k = 0; k < 3; ++k) n = n + X.R[i][k] * Load8(b.normal[k]);
    Store8(normal[i], n);
    shift = shift + n * Load8(corner[0][i]);
  }
  Store8(offset, shift);

  std::uint64_t kept = 0;
  for (int j = 0; j < 8; ++j) {
    if ((pairs >> (8 * j) & 0xff) == 0) continue;
    Float8 low_b{}, high_b{}, low_a{}, high_a{};
    for (int c = 0; c < 3; ++c) {
      // Corner c of the facets of a over facet j's plane, and corner c of facet j over theirs.
      Float8 over_b = Fill8(-offset[j]), over_a = -Load8(a.offset);
      for (int i = 0; i < 3; ++i) {
        over_b = over_b + normal[i][j] * Load8(a.vertex[c][i]);
        over_a = over_a + corner[c][i][j] * Load8(a.normal[i]);
      }
      low_b = c == 0 ? over_b : Least(low_b, over_b);
      high_b = c == 0 ? over_b : Most(high_b, over_b);
      low_a = c == 0 ? over_a : Least(low_a, over_a);
      high_a = c == 0 ? over_a : Most(high_a, over_a);
    }
    const Float8 gap = Most(Most(low_b, -high_b), Most(low_a, -high_a));
    std::uint64_t row = Bits(gap <= Fill8(limit)) & (pairs >> (8 * j) & 0xff);
    if (row != 0) {
      Triangle<Float8> ta, tb;
      for (int c = 0; c < 3; ++c) {
        ta.corner[c] = {Load8(a.vertex[c][0]), Load8(a.vertex[c][1]), Load8(a.vertex[c][2])};
        tb.corner[c] = {Fill8(corner[c][0][j]), Fill8(corner[c][1][j]), Fill8(corner[c][2][j])};
      }
      row &= Bits(MayBeNear(ta, tb, Fill8(limit)));
    }
    kept |= row << (8 * j);
  }
  return pairs & kept;
}

}  // namespace
}  // namespace contact_toolkit
