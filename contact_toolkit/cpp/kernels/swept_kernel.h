// Culling of moving boxes and facets in single precision. Included by one source file per
// instruction set, inside an unnamed namespace.
#pragma once

#include "base/tolerances.h"
#include "kernels/facet_cull.h"
#include "kernels/lanes.h"
#include "kernels/separation.h"
#include "kernels/slabs.h"
#include "kernels/swept_kernels.h"

namespace contact_toolkit {
namespace {

template <class V>
CT_INLINE Float8 Row(const float (&row)[3], const V& v) {
  return row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
}

// How far points of B stray from the straight line between their two ends in the slice.
CT_INLINE Float8 Bow(const SweptCull& cull, const Float8 (&c)[3]) {
  const Float8 q[3]{c[0] + cull.from_Bo[0], c[1] + cull.from_Bo[1], c[2] + cull.from_Bo[2]};
  const Float8 along = Row(cull.axis, q);
  const Float8 squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - along * along;
  return cull.bow * SquareRoot(Most(squared, Float8{}));
}

// Boxes in A around all that the children of b, eight at once, sweep over.
struct SweptBoxes {
  alignas(32) float center[3][8], half[3][8];
  float furthest;  // [m] that any of them goes, either way from the middle
};

CT_INLINE void Translate(const Float8 (&c)[3], const Float8 (&h)[3], const SweptCull& cull,
                         SweptBoxes* boxes) {
  boxes->furthest = 0;
  for (int i = 0; i < 3; ++i) {
    const float begin = cull.p_begin[i], end = cull.p_end[i];
    const float way = 0.5f * (end > begin ? end - begin : begin - end);
    Store8(boxes->center[i], Row(cull.R[i], c) + 0.5f * (begin + end));
    Store8(boxes->half[i], Row(cull.abs_R[i], h) + (way + cull.slack));
    boxes->furthest = way > boxes->furthest ? way : boxes->furthest;
  }
}

CT_INLINE void Turn(const Float8 (&c)[3], const Float8 (&h)[3], int count, const SweptCull& cull,
                    SweptBoxes* boxes) {
  const Float8 bow = Bow(cull, c);
  const Float8 swell = bow + cull.turn * SquareRoot(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
  Float8 furthest = bow;
  for (int i = 0; i < 3; ++i) {
    const Float8 begin = Row(cull.R_begin[i], c) + cull.p_begin[i];
    const Float8 end = Row(cull.R_end[i], c) + cull.p_end[i];
    const Float8 way = Absolute(0.5f * (end - begin));
    Store8(boxes->center[i], 0.5f * (begin + end));
    Store8(boxes->half[i], Row(cull.abs_R[i], h) + way + (swell + cull.slack));
    furthest = Most(furthest, way);
  }
  boxes->furthest = 0;
  for (int j = 0; j < count; ++j) {
    boxes->furthest = furthest[j] > boxes->furthest ? furthest[j] : boxes->furthest;
  }
}

// The children of b against those of a over the slice.
struct SweptNodes {
  const BvhNode &a, &b;
  const SweptCull& cull;
  SweptBoxes boxes;
  Float8 across_a[3];
  alignas(32) float across_b[3][8];

  CT_INLINE SweptNodes(const BvhNode& a, const BvhNode& b, const SweptCull& cull)
      : a(a), b(b), cull(cull) {
    const Float8 c[3]{Load8(b.center[0]), Load8(b.center[1]), Load8(b.center[2])};
    const Float8 h[3]{Load8(b.half[0]), Load8(b.half[1]), Load8(b.half[2])};
    if (cull.turn > 0) {
      Turn(c, h, b.count, cull, &boxes);
    } else {
      Translate(c, h, cull, &boxes);
    }
    for (int n = 0; n < cull.across_count; ++n) {
      const Float8 half_a[3]{Load8(a.half[0]), Load8(a.half[1]), Load8(a.half[2])};
      across_a[n] = Row(cull.abs_across_A[n], half_a);
      Store8(across_b[n], Row(cull.abs_across_B[n], h) + cull.slack);
    }
  }

  // From the box of child j to those of a, middle to middle.
  CT_INLINE void Offsets(int j, Float8 (&offset)[3]) const {
    for (int i = 0; i < 3; ++i) offset[i] = Load8(a.center[i]) - boxes.center[i][j];
  }

  // Lower bounds of the squared distances of child j.
  CT_INLINE Float8 Squared(int j, const Float8 (&offset)[3]) const {
    Float8 squared{};
    for (int i = 0; i < 3; ++i) {
      Float8 gap = Absolute(offset[i]) - Load8(a.half[i]) - boxes.half[i][j];
      gap = Most(gap, Float8{});
      squared = squared + gap * gap;
    }
    for (int n = 0; n < cull.across_count; ++n) {
      const Float8 along = Absolute(Row(cull.across[n], offset));
      const Float8 gap = Most(along - across_a[n] - across_b[n][j], Float8{});
      squared = Most(squared, gap * gap);
    }
    return squared;
  }
};

float SweptBoxBounds(const BvhNode& a, const BvhNode& b, const SweptCull& cull, float squared_reach,
                     float bound[64], std::uint64_t* near) {
  const SweptNodes nodes(a, b, cull);
  *near = 0;
  for (int j = 0; j < b.count; ++j) {
    Float8 offset[3];
    nodes.Offsets(j, offset);
    const Float8 squared = nodes.Squared(j, offset) * (1 - kBoundRounding);
    Store8(bound + 8 * j, squared);
    *near |= (Bits(squared <= Fill8(squared_reach)) & LanesUsed(a.count)) << (8 * j);
  }
  return nodes.boxes.furthest;
}

// Where the boxes of B are half-way through a translation, in A, and half the way.
struct MiddleOfWay {
  float p[3], half_way[3];

  CT_INLINE explicit MiddleOfWay(const SweptCull& cull) {
    for (int i = 0; i < 3; ++i) {
      p[i] = 0.5f * (cull.p_begin[i] + cull.p_end[i]);
      half_way[i] = 0.5f * (cull.p_end[i] - cull.p_begin[i]);
    }
  }
};

// Calls visit(j, squared lower bounds, offsets of the middles half-way) for each child j of b.
template <class Visit>
CT_INLINE std::uint64_t ForTranslation(const SweptNodes& nodes, const MiddleOfWay& at, float limit,
                                       Visit visit) {
  const BvhNode &a = nodes.a, &b = nodes.b;
  PosedSlabs slabs(a, b, nodes.cull.R, at.p);
  slabs.Sweep(a, at.half_way);
  std::uint64_t near = 0;
  for (int j = 0; j < b.count; ++j) {
    Float8 offset[3];
    nodes.Offsets(j, offset);
    Float8 squared = nodes.Squared(j, offset);
    float size = 0;
    for (int i = 0; i < 3; ++i) size += nodes.boxes.half[i][j];
    if (Bits(squared <= Fill8(Least(limit, size * size))) != 0) {
      const Float8 gap = Most(slabs.Gaps(a, b, nodes.boxes.center, j, nodes.cull.slack), Float8{});
      squared = Most(gap * gap, squared);
    }
    squared = squared * (1 - kBoundRounding);
    near |= (Bits(squared <= Fill8(limit)) & LanesUsed(a.count)) << (8 * j);
    visit(j, squared, offset);
  }
  return near;
}

std::uint64_t TranslationBounds(const BvhNode& a, const BvhNode& b, const SweptCull& cull,
                                float limit, float bound[64]) {
  return ForTranslation(
      SweptNodes(a, b, cull), MiddleOfWay(cull), limit,
      [&](int j, Float8 squared, const Float8(&)[3]) { Store8(bound + 8 * j, squared); });
}

std::uint64_t TranslationOrders(const BvhNode& a, const BvhNode& b, const SweptCull& cull,
                                const float p[3], float limit, float middles, float bound[64],
                                float order[64]) {
  const SweptNodes nodes(a, b, cull);
  const MiddleOfWay at(cull);
  return ForTranslation(
      nodes, at, limit, [&](int j, Float8 squared, const Float8(&half_way_offset)[3]) {
        Float8 posed{}, apart{};
        for (int i = 0; i < 3; ++i) {
          const Float8 offset = half_way_offset[i] + (at.p[i] - p[i]);
          const float stretch = at.half_way[i] < 0 ? -at.half_way[i] : at.half_way[i];
          const float half = nodes.boxes.half[i][j] - stretch;
          const Float8 gap = Most(Absolute(offset) - Load8(a.half[i]) - half, Float8{});
          posed = posed + gap * gap;
          apart = apart + offset * offset;
        }
        Store8(bound + 8 * j, squared);
        Store8(order + 8 * j, Most(posed, squared) + middles * apart);
      });
}

// Least and most of the three corners along the direction (8 lanes of facets).
struct Span8 {
  Float8 low, high;
  CT_INLINE void Add(Float8 x) {
    low = Least(low, x);
    high = Most(high, x);
  }
};

std::uint64_t SweptFacetCull(const FacetBlock& a, const FacetBlock& b, const SweptCull& cull,
                             const float direction[3], float reach, std::uint64_t pairs) {
  if (cull.turn == 0) {
    const MiddleOfWay at(cull);
    const float along[3]{direction[0], direction[1], direction[2]};
    return CullFacets<true>(a, b, cull.R, at.p, at.half_way, along,
                            reach * (1 + kBoundRounding) + cull.slack, pairs);
  }
  // Corners of b at both ends of the slice, and how far they stray in between.
  alignas(32) float corner[6][3][8], stray[8], low_b[8], high_b[8];
  Float8 bow{};
  for (int v = 0; v < 3; ++v) {
    const Float8 c[3]{Load8(b.vertex[v][0]), Load8(b.vertex[v][1]), Load8(b.vertex[v][2])};
    bow = Most(bow, Bow(cull, c));
    for (int i = 0; i < 3; ++i) {
      Store8(corner[v][i], Row(cull.R_begin[i], c) + cull.p_begin[i]);
      Store8(corner[3 + v][i], Row(cull.R_end[i], c) + cull.p_end[i]);
    }
  }
  Store8(stray, bow + (reach * (1 + kBoundRounding) + cull.slack));

  // Along the given direction.
  Span8 spread_a{Fill8(3e38f), Fill8(-3e38f)}, spread_b = spread_a;
  for (int v = 0; v < 3; ++v) {
    const Float8 x[3]{Load8(a.vertex[v][0]), Load8(a.vertex[v][1]), Load8(a.vertex[v][2])};
    spread_a.Add(direction[0] * x[0] + direction[1] * x[1] + direction[2] * x[2]);
  }
  for (int v = 0; v < 6; ++v) {
    const Float8 x[3]{Load8(corner[v][0]), Load8(corner[v][1]), Load8(corner[v][2])};
    spread_b.Add(direction[0] * x[0] + direction[1] * x[1] + direction[2] * x[2]);
  }
  Store8(low_b, spread_b.low);
  Store8(high_b, spread_b.high);

  std::uint64_t kept = 0;
  for (int j = 0; j < 8; ++j) {
    if ((pairs >> (8 * j) & 0xff) == 0) continue;
    Span8 over_a{Fill8(3e38f), Fill8(-3e38f)};
    for (int v = 0; v < 6; ++v) {
      over_a.Add(corner[v][0][j] * Load8(a.normal[0]) + corner[v][1][j] * Load8(a.normal[1]) +
                 corner[v][2][j] * Load8(a.normal[2]));
    }
    const Float8 offset = Load8(a.offset);
    Float8 gap = Most(over_a.low - offset, offset - over_a.high);
    gap = Most(gap, Most(spread_a.low - high_b[j], low_b[j] - spread_a.high));
    std::uint64_t row = Bits(gap <= Fill8(stray[j])) & (pairs >> (8 * j) & 0xff);
    if (row != 0) {
      Triangle<Float8> ta;
      TwoPoses<Float8> tb;
      for (int v = 0; v < 3; ++v) {
        ta.corner[v] = {Load8(a.vertex[v][0]), Load8(a.vertex[v][1]), Load8(a.vertex[v][2])};
        const auto fill = [&](const float (&c)[3][8]) {
          return Vec<Float8>{Fill8(c[0][j]), Fill8(c[1][j]), Fill8(c[2][j])};
        };
        tb.begin.corner[v] = fill(corner[v]);
        tb.end.corner[v] = fill(corner[3 + v]);
      }
      row &= Bits(MayBeNear(ta, tb, Middle(ta) - Middle(tb), Fill8(stray[j])));
    }
    kept |= row << (8 * j);
  }
  return pairs & kept;
}

}  // namespace
}  // namespace contact_toolkit
