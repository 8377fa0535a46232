// Lower bounds of the distances of a point from what a node holds, in single precision. Included by
// one source file per instruction set, inside an unnamed namespace.
#pragma once

#include "kernels/box_kernel.h"
#include "kernels/kernels.h"
#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

CT_INLINE Float8 SquaredBeyond(Float8 distance, float slack) {
  const Float8 beyond = Most(distance - slack, Float8{});
  return beyond * beyond;
}

CT_INLINE Float8 SquaredFromBoxes(const BvhNode& node, const CullPoint& point) {
  Float8 squared{};
  for (int i = 0; i < 3; ++i) {
    const Float8 offset = point.p[i] - Load8(node.center[i]);
    squared = squared + SquaredBeyond(Absolute(offset) - Load8(node.half[i]), point.slack);
  }
  return squared;
}

CT_INLINE Float8 SquaredFromSlabs(const BvhNode& node, const CullPoint& point) {
  Float8 from = -Load8(node.middle);
  for (int i = 0; i < 3; ++i) from = from + point.p[i] * Load8(node.normal[i]);
  return 0.9999f * SquaredBeyond(Absolute(from) - Load8(node.thick), point.slack);
}

CT_INLINE unsigned StoreBounds(const BvhNode& node, Float8 squared, float limit, float bound[8]) {
  Store8(bound, squared);
  return static_cast<unsigned>(Bits(squared <= Fill8(limit)) & LanesUsed(node.count));
}

unsigned PointBoxBounds(const BvhNode& node, const CullPoint& point, float limit, float bound[8]) {
  const Float8 squared = Most(SquaredFromSlabs(node, point), SquaredFromBoxes(node, point));
  return StoreBounds(node, squared, limit, bound);
}

// The distance to the facet: to its plane where the foot lies inside, else to the nearest edge. Of
// a facet too thin to have a plane, to its box. Where rounding puts a foot on the wrong side of an
// edge, the two differ by no more than rounding; along an edge, the best foot is a minimum.
unsigned PointFacetBounds(const BvhNode& node, const FacetBlock& block, const CullPoint& point,
                          float limit, float bound[8]) {
  using V = Vec<Float8>;
  const Float8 zero{}, one = Fill8(1);
  const V n{Load8(block.normal[0]), Load8(block.normal[1]), Load8(block.normal[2])};
  V r[3];  // from each corner to the point
  for (int c = 0; c < 3; ++c) {
    r[c] = {point.p[0] - Load8(block.vertex[c][0]), point.p[1] - Load8(block.vertex[c][1]),
            point.p[2] - Load8(block.vertex[c][2])};
  }
  Float8 squared = Fill8(3e38f);
  auto inside = zero == zero;
  for (int c = 0; c < 3; ++c) {
    const V side = r[c] - r[(c + 1) % 3];
    const Float8 t = Most(zero, Least(one, Dot(r[c], side) / Dot(side, side)));
    const V v = r[c] - t * side;
    squared = Least(squared, Dot(v, v));
    inside = inside & (Dot(r[c], Cross(n, side)) > zero);
  }
  const Float8 height = Absolute(Dot(r[0], n));
  const Float8 distance = Select(inside, height, SquareRoot(squared));
  Float8 least = SquaredBeyond(distance, 2 * point.slack);
  const auto thin = Dot(n, n) == zero;
  if (Bits(thin) != 0) least = Select(thin, SquaredFromBoxes(node, point), least);
  return StoreBounds(node, least, limit, bound);
}

}  // namespace
}  // namespace contact_toolkit
