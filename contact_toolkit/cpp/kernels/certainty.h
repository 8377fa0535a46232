// Whether a pair of points is the closest of two facets beyond what rounding can hide.
//
// Facets are convex: pa on A and pb on B are closest, with v = pa − pb, just when no corner of A
// lies behind pa along v and none of B before pb. Then any points x = Σ λ A_k and y = Σ μ B_k are
// farther apart: |x − y|² = |v|² + E, E = 2 Σ (λ + μ) h + |x − y − v|², summed over the heights h ≥
// 0 of the corners off the points' features. Two things follow if these heights are h at least, and
// the points keep a room r from the ends of their features (two edges: across the other one).
//
// 1. On other features, E ≥ min(h r / D, r² / 16), D being the longest edge plus the distance:
//    either x − y is as far from v as r / 4, or λ and μ that add up to r / (2 D) brought it back.
//    At a corner off the features, E ≥ 2 h. What exceeds ρ², the error of the fast kernel's squared
//    distances, cannot win.
// 2. Points on features next to a corner, as near to it as one likes, are left out by a sign: the
//    feet on lines and planes through it lie outside by h. Rounding changes that, and the heights
//    themselves, by a multiple of D²: a small one, but as the inverse of sin² between the edges, or
//    of the facet's height over its longest edge, squared.
//
// So heights may be tiny, as along nearly parallel edges, if there is room.
#pragma once

#include <limits>

#include "base/tolerances.h"
#include "kernels/kernels.h"
#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

// The margins at a distance between facets of a size, rounding being relative to both.
template <class V>
struct Margin {
  V share;    // [-] the error of a distance over D
  V span;     // [m] D: longest edge plus distance
  V squared;  // [m²] ρ²: that error's of the squared distance

  CT_INLINE Margin(V longest, V distance, double share)
      : share(Fill<V>(share)),
        span(longest + distance),
        squared(this->share * span * (distance + distance + this->share * span)) {}

  // Of the least height along v [m²], and how many times as far as on a single edge rounding moves
  // the points.
  CT_INLINE auto Clears(V height, V condition) const {
    return height >= share * (Fill<V>(1) + Fill<V>(kFootError) * condition) * span * span;
  }
  // Of a squared room times a scale, that scale, and the least height.
  CT_INLINE auto HasRoom(V room, V scale, V height) const {
    return (room >= Fill<V>(16) * squared * scale) &
           (height * height * room >= squared * squared * span * span * scale);
  }
};

// The fraction of an edge's length to its nearer end; likewise for barycentric coordinates.
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

  V height = Fill<V>(std::numeric_limits<double>::infinity());
  for (int k = 0; k < 3; ++k) {
    height = Select(a.has_corner[k], height, Least(height, Dot(A[k] - a_point, v)));
    height = Select(b.has_corner[k], height, Least(height, Dot(b_point - B[k], v)));
  }
  const V one = Fill<V>(1);
  const V ab = Select(a.is_edge & b.is_edge, Dot(a.edge, b.edge), zero);
  const V scale = a.squared_length * b.squared_length, nn = scale - ab * ab;
  const Vec<V> na = Cross(sides_a[0], sides_a[2]), nb = Cross(sides_b[0], sides_b[2]);
  const V nna = Dot(na, na), nnb = Dot(nb, nb);
  const auto is_corner_a = !(a.is_edge | a.is_inside), is_corner_b = !(b.is_edge | b.is_inside);
  const V worst = Select(is_corner_a & is_corner_b, Fill<V>(kWorstCondition), one);
  const V condition = Select(a.is_inside | b.is_inside,
                             squared_longest * squared_longest / Select(a.is_inside, nna, nnb),
                             Select(a.is_edge & b.is_edge, scale / nn, worst));
  const V room_a = Room(s), room_b = Room(t), room = Room(s, t);
  return margin.Clears(height, condition) &
         ((!a.is_edge) | margin.HasRoom(room_a * room_a * nn, b.squared_length, height)) &
         ((!b.is_edge) | margin.HasRoom(room_b * room_b * nn, a.squared_length, height)) &
         ((!a.is_inside) | margin.HasRoom(room * room * nna, squared_longest, height)) &
         ((!b.is_inside) | margin.HasRoom(room * room * nnb, squared_longest, height));
}

// Whether the distance of a pair of points, `apart` = pa - pb, is the facets' to the fraction
// kProven: the planes across it through their nearest corners leave at least that much between
// them. It holds whatever the kernel did to find the points, and shows that the facets do not
// cross.
template <class V>
CT_INLINE auto ProvenByPlanes(const Vec<V> (&A)[3], const Vec<V> (&B)[3], const Vec<V>& b_point,
                              const Vec<V>& apart, V distance) {
  V lowest = Dot(A[0] - b_point, apart), highest = Dot(B[0] - b_point, apart), squared_longest{};
  for (int k = 0; k < 3; ++k) {
    lowest = Least(lowest, Dot(A[k] - b_point, apart));
    highest = Most(highest, Dot(B[k] - b_point, apart));
    const Vec<V> side_a = A[(k + 1) % 3] - A[k], side_b = B[(k + 1) % 3] - B[k];
    squared_longest = Most(squared_longest, Most(Dot(side_a, side_a), Dot(side_b, side_b)));
  }
  const V span = SquareRoot(squared_longest) + distance;
  return (distance * distance - (lowest - highest) <= Fill<V>(kProven) * span * distance) &
         (distance > Fill<V>(kProvenApart) * span);
}

}  // namespace
}  // namespace contact_toolkit
