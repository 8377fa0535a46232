// From spots on two facets to the closest points there, several pairs at once, and what is put out
// of them. Included by one source file per instruction set, inside an unnamed namespace.
#pragma once

#include "base/tolerances.h"
#include "kernels/certainty.h"
#include "kernels/facet_lanes.h"
#include "kernels/kernels.h"
#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

constexpr int kEdgeBase[3] = {0, 1, 0};
constexpr int kEdgeEnd[3] = {1, 2, 2};
// [m²] More than any squared distance of coordinates within kMaxCoordinate.
constexpr double kUnreached = 1e38;
// Less than any squared length, or product of two of them.
constexpr double kNoLength = 1e-300;

template <class V>
CT_INLINE V Inverse(V a) {
  if constexpr (IsSingle<V>()) {
    return RoughInverse(a);
  } else {
    return Fill<V>(1) / a;
  }
}

template <class V>
CT_INLINE V InverseOrZero(V a) {
  return Select(a > V{}, Inverse(a), V{});
}

// A share of an edge's length, kept on the edge.
template <class V>
CT_INLINE V Clamped(V share) {
  return Most(V{}, Least(Fill<V>(1), share));
}

// The spot at a share of an edge's length: one of its ends, if it is there.
template <class V>
CT_INLINE V SpotOnEdge(V edge, V share) {
  const V base = Select(edge == Fill<V>(1), Fill<V>(kOnCorner + 1), Fill<V>(kOnCorner));
  const V end = Select(edge == V{}, Fill<V>(kOnCorner + 1), Fill<V>(kOnCorner + 2));
  return Select(share <= V{}, base, Select(share >= Fill<V>(1), end, edge + Fill<V>(kOnEdge)));
}

// A spot of facet P: where its points start from, and which way they go; a corner stays.
template <class V>
struct Spot {
  V spot, from_edges;  // how far its number is from those of edges: up to 1 on these
  decltype(V{} < V{}) on_edge, inside;
  Vec<V> base, along, across;

  CT_INLINE Spot(const Vec<V> (&P)[3], V spot)
      : spot(spot), from_edges(Absolute(spot - Fill<V>(kOnEdge + 1))) {
    const auto at = [&](int where) { return spot == Fill<V>(where); };
    on_edge = from_edges < Fill<V>(1.5);
    inside = at(kInside);
    base = Select(at(kOnCorner + 1), P[1], Select(at(kOnCorner + 2), P[2], P[0]));
    base = Select(at(kOnEdge + 1), P[1], base);
    Vec<V> end = Select(on_edge, P[2], base);
    end = Select(at(kOnEdge), P[1], end);
    along = Select(inside, P[1], end) - base;
    across = P[2] - P[0];
  }

  // The point at the share `share` of an edge, or the barycentric coordinates (1 - s - t, s, t).
  CT_INLINE Vec<V> Point(V share, V s, V t) const {
    return base + Select(inside, s, share) * along + Select(inside, t, V{}) * across;
  }
};

// The products of which the foot on a facet, of the point at r from its corner 0, has the
// barycentric coordinates (1 - u - w, u, w) / nn.
template <class V>
struct Foot {
  V u, w, nn;

  CT_INLINE Foot(const Vec<V>& d0, const Vec<V>& d2, const Vec<V>& r) {
    const Vec<V> n = Cross(d0, d2);
    nn = Dot(n, n);
    u = Dot(r, Cross(d2, n));
    w = Dot(r, Cross(n, d0));
  }
};

// The closest points of corners and edges by those alone, at shares s and t of their lengths; with
// feet also those of corners and insides, at barycentric coordinates (1 - s - t, s, t).
template <class V, bool feet>
struct Solution {
  decltype(V{} < V{}) both, inside;  // edges; one of the facets
  V aa, bb, nn;  // squared lengths of edges; of two times sin², of one, or of the facet's normal
  V s, t;

  CT_INLINE Solution(const Spot<V>& a, const Spot<V>& b)
      : both(Most(a.from_edges, b.from_edges) < Fill<V>(1.5)),
        inside(Most(a.spot, b.spot) >= Fill<V>(kInside)),
        aa(Dot(a.along, a.along)),
        bb(Dot(b.along, b.along)) {
    const Vec<V> r = a.base - b.base;
    const V ab = Dot(a.along, b.along), p = Dot(r, a.along), q = Dot(r, b.along);
    nn = Select(both, aa * bb - ab * ab, aa + bb);
    s = Select(both, ab * q - bb * p, -p);
    t = Select(both, aa * q - ab * p, q);
    if constexpr (feet) {
      const Foot<V> foot(Select(a.inside, a.along, b.along), Select(a.inside, a.across, b.across),
                         Select(a.inside, -r, r));
      nn = Select(inside, foot.nn, nn);
      s = Select(inside, foot.u, s);
      t = Select(inside, foot.w, t);
    }
    // Corners stay where they are.
    const V one = Fill<V>(1), inverse = one / Most(nn, Fill<V>(kNoLength));
    s = Most(V{},
             Least(Select(a.spot >= Fill<V>(kOnEdge), one, Select(inside, one, V{})), s * inverse));
    t = Most(V{},
             Least(Select(b.spot >= Fill<V>(kOnEdge), one, Select(inside, one, V{})), t * inverse));
  }
};

// Where points lie that are as near to the end of an edge, or the rim of a facet, as to be on it.
// along: on an edge.
template <class V>
CT_INLINE V Snapped(V spot, V along, V s, V t) {
  const V one = Fill<V>(1), least = Fill<V>(kOnFeature), most = one - least;
  const V edge = spot - Fill<V>(kOnEdge), weight[3] = {one - s - t, s, t};
  V room = Select(spot == Fill<V>(kInside), Room(s, t), one);
  room = Select(Absolute(edge - one) < Fill<V>(1.5), Room(along), room);
  if (!Any(room <= least)) return spot;
  const V rounded = Select(along <= least, V{}, Select(along >= most, one, Fill<V>(0.5)));
  const V on_edge = SpotOnEdge(edge, rounded);
  // Edge 1 is opposite corner 0, edge 2 opposite corner 1, edge 0 opposite corner 2.
  V inside = spot;
  for (int k = 2; k >= 0; --k) {
    inside = Select(weight[k] <= least, Fill<V>(kOnEdge + (k + 1) % 3), inside);
  }
  for (int k = 2; k >= 0; --k) inside = Select(weight[k] >= most, Fill<V>(kOnCorner + k), inside);
  const V snapped = Select(spot == Fill<V>(kInside), inside, on_edge);
  return Select(room <= least, snapped, spot);
}

// What the kernel puts out of a batch. needs_care: added to the spot on A.
template <class V>
CT_INLINE void StoreMeasured(int first, V spot_a, V spot_b, V needs_care, V s, V t,
                             const Vec<V>& a_point, const Vec<V>& b_point, const Vec<V>& apart,
                             V distance, FacetPairs* pairs) {
  const V inverse = Fill<V>(1) / distance;
  Store(pairs->distance + first, Select(spot_b == Fill<V>(kCrossing), V{}, distance));
  Store(pairs->spot_a + first, Snapped(spot_a, s, s, t) + needs_care);
  Store(pairs->spot_b + first, Snapped(spot_b, t, s, t));
  Store(pairs->point_a[0] + first, a_point.x);
  Store(pairs->point_a[1] + first, a_point.y);
  Store(pairs->point_a[2] + first, a_point.z);
  Store(pairs->point_b[0] + first, b_point.x);
  Store(pairs->point_b[1] + first, b_point.y);
  Store(pairs->point_b[2] + first, b_point.z);
  Store(pairs->normal[0] + first, inverse * apart.x);
  Store(pairs->normal[1] + first, inverse * apart.y);
  Store(pairs->normal[2] + first, inverse * apart.z);
}

// The facets of a batch, both in A.
template <class V, int lanes>
CT_INLINE void LoadPair(const double* a, const double* b, const double* X, const FacetPairs& pairs,
                        int first, Vec<V> (&A)[3], Vec<V> (&B)[3]) {
  Vec<V> b_B[3];
  LoadFacets<V, lanes>(a, pairs.slot_a + first, A);
  LoadFacets<V, lanes>(b, pairs.slot_b + first, b_B);
  for (int c = 0; c < 3; ++c) B[c] = Posed(X, b_B[c]);
}

// Fills the last batch up with copies of the last pair.
inline void FillUp(int lanes, FacetPairs* pairs) {
  for (int k = pairs->count; k % lanes != 0; ++k) {
    pairs->slot_a[k] = pairs->slot_a[pairs->count - 1];
    pairs->slot_b[k] = pairs->slot_b[pairs->count - 1];
  }
}

}  // namespace
}  // namespace contact_toolkit
