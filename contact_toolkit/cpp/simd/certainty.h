// Whether a pair of points is the closest of two facets beyond what rounding can hide.
//
// Facets are convex: pa on A and pb on B are closest, with v = pa − pb, just when no corner of A
// lies behind pa along v and none of B before pb. If the corners that do not belong to the points'
// features are clear of that by a margin, and the points are clear of their features' ends, then
// any other two points, one of which is not on its feature, are farther apart. By how much: with
// heights h ≥ ρ D of the clear corners and room r ≥ 4 ρ towards the ends, squared distances differ
// by more than ρ². So the margin ρ is chosen above the error of the kernels' squared distances, and
// the case that wins is then the same whatever the order of the operations.
#pragma once

#include "simd/kernels.h"
#include "simd/lanes.h"
#include "tolerances.h"

namespace contact_toolkit {
namespace {

// The margins at a distance between facets of a size, rounding being relative to both.
template <class V>
struct Margin {
  V span;     // [m] D: longest edge plus distance
  V squared;  // [m²] ρ²: a share of D, as an error of the distance, makes this of its square

  CT_INLINE Margin(V longest, V distance, double share)
      : span(longest + distance),
        squared(Fill<V>(share) * span * (distance + distance + Fill<V>(share) * span)) {}

  // A corner's height along v [m²].
  CT_INLINE auto Clears(V height) const {
    return (height > V{}) & (height * height >= squared * span * span);
  }
  // A squared length times a scale, against that scale.
  CT_INLINE auto HasRoom(V room, V scale) const { return room >= Fill<V>(16) * squared * scale; }
};

// The share of an edge's length to its nearer end; likewise for barycentric coordinates.
template <class V>
CT_INLINE V Room(V along) {
  return Least(along, Fill<V>(1) - along);
}
template <class V>
CT_INLINE V Room(V u, V w) {
  return Least(Least(u, w), Fill<V>(1) - u - w);
}

// The feature of facet P at a spot.
template <class V>
struct FeatureAtSpot {
  using Mask = decltype(V{} < V{});
  Mask has_corner[3], is_edge, is_inside;
  Vec<V> edge;  // where it is one
  V squared_length = Fill<V>(1);

  CT_INLINE FeatureAtSpot(const Vec<V> (&P)[3], V spot, V along) {
    const V zero{}, one = Fill<V>(1);
    const auto on = [&](int where) { return spot == Fill<V>(where); };
    const Mask edge0 = on(kOnEdge), edge1 = on(kOnEdge + 1), edge2 = on(kOnEdge + 2);
    const Mask not_end = along<one, not_base = along> zero;
    is_inside = on(kInside);
    has_corner[0] = on(kOnCorner) | is_inside | ((edge0 | edge2) & not_end);
    has_corner[1] = on(kOnCorner + 1) | is_inside | (edge0 & not_base) | (edge1 & not_end);
    has_corner[2] = on(kOnCorner + 2) | is_inside | ((edge1 | edge2) & not_base);
    is_edge = (edge0 | edge1 | edge2) & not_end & not_base;
    edge = Select(edge0, P[1] - P[0], Select(edge1, P[2] - P[1], P[2] - P[0]));
    squared_length = Select(is_edge, Dot(edge, edge), one);
  }
};

// Whether no other points of A and B can be closer, or as close, than those of the best case.
template <class V>
CT_INLINE auto Certain(const Vec<V> (&A)[3], const Vec<V> (&B)[3], V spot_a, V spot_b, V s, V t,
                       const Vec<V>& a_point, const Vec<V>& b_point, V distance) {
  const V zero{};
  const FeatureAtSpot<V> a(A, spot_a, s), b(B, spot_b, t);
  const Vec<V> v = a_point - b_point, sides_a[3] = {A[1] - A[0], A[2] - A[1], A[2] - A[0]},
               sides_b[3] = {B[1] - B[0], B[2] - B[1], B[2] - B[0]};
  V squared_longest = zero;
  for (int k = 0; k < 3; ++k) {
    squared_longest = Most(squared_longest, Dot(sides_a[k], sides_a[k]));
    squared_longest = Most(squared_longest, Dot(sides_b[k], sides_b[k]));
  }
  const Margin<V> margin(SquareRoot(squared_longest), distance, kCertain);

  auto certain = zero == zero;
  for (int k = 0; k < 3; ++k) {
    certain = certain & (a.has_corner[k] | margin.Clears(Dot(A[k] - a_point, v)));
    certain = certain & (b.has_corner[k] | margin.Clears(Dot(b_point - B[k], v)));
  }
  const V ab = Select(a.is_edge & b.is_edge, Dot(a.edge, b.edge), zero);
  const V nn = a.squared_length * b.squared_length - ab * ab;
  const V room_a = Room(s), room_b = Room(t), room = Room(s, t);
  const Vec<V> na = Cross(sides_a[0], sides_a[2]), nb = Cross(sides_b[0], sides_b[2]);
  return certain & ((!a.is_edge) | margin.HasRoom(room_a * room_a * nn, b.squared_length)) &
         ((!b.is_edge) | margin.HasRoom(room_b * room_b * nn, a.squared_length)) &
         ((!a.is_inside) | margin.HasRoom(room * room * Dot(na, na), squared_longest)) &
         ((!b.is_inside) | margin.HasRoom(room * room * Dot(nb, nb), squared_longest));
}

}  // namespace
}  // namespace contact_toolkit
