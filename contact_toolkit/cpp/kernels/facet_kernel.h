// The distance between triangles, several pairs at once. Included by one source file per
// instruction set, inside an unnamed namespace.
//
// The closest points lie on edges, ends included (9 cases), on a corner and inside a facet (6), or
// the facets cross (an edge pierces a facet: 6). The fast kernel ranks pairs of edges with dot
// products and insides by heights over planes, then solves the winner anew from its own corners
// alone, on which its points must depend only. Where that loses accuracy it asks for the careful
// one, in which every candidate is a pair of points of the two facets whose difference is measured,
// so that rounding of its parameters enters the distance only to second order. The fast kernel
// passes over what nearly parallel edges have between their ends, and asks unless the answer is
// certain without.
#pragma once

#include <limits>

#include "base/tolerances.h"
#include "kernels/certainty.h"
#include "kernels/facet_lanes.h"
#include "kernels/facet_points.h"
#include "kernels/kernels.h"
#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

// The nearest candidate so far.
template <class V>
struct Nearest {
  V squared_distance = Fill<V>(kUnreached), s{}, t{}, spot_a{}, spot_b{};

  CT_INLINE void Offer(V d2, V s_new, V t_new, V spot_a_new, V spot_b_new) {
    const auto better = d2 < squared_distance;
    squared_distance = Select(better, d2, squared_distance);
    s = Select(better, s_new, s);
    t = Select(better, t_new, t);
    spot_a = Select(better, spot_a_new, spot_a);
    spot_b = Select(better, spot_b_new, spot_b);
  }
};

template <class V>
struct Edges {
  Vec<V> along[3];
  V squared[3], inverse[3];  // of the lengths

  CT_INLINE explicit Edges(const Vec<V> (&P)[3]) {
    CT_UNROLL
    for (int e = 0; e < 3; ++e) {
      along[e] = P[kEdgeEnd[e]] - P[kEdgeBase[e]];
      squared[e] = Dot(along[e], along[e]);
      inverse[e] = InverseOrZero(squared[e]);
    }
  }

  CT_INLINE V SquaredLongest() const { return Most(squared[0], Most(squared[1], squared[2])); }
};

// The edges of A against those of B.
//
// The share s at which two lines are closest, kept on its edge, is followed to the nearest t on the
// other edge, and from there back. All nine pairs take each step together: their chains of
// operations are long, and the processor looks only one or two such chains ahead.
template <class V, bool careful>
struct EdgePairs {
  Nearest<V> nearest;
  decltype(V{} < V{}) needs_care = V{} != V{};  // nearly parallel ones, passed over in part

  // r[i][j]: from corner j of B to corner i of A.
  CT_INLINE EdgePairs(const Edges<V>& a, const Edges<V>& b, const Vec<V> (&r)[3][3]) {
    const V zero{}, one = Fill<V>(1);
    V on_a[3], on_b[3];
    CT_UNROLL
    for (int e = 0; e < 3; ++e) {
      on_a[e] = Dot(r[kEdgeBase[e]][0], a.along[e]);
      on_b[e] = Dot(r[0][kEdgeBase[e]], b.along[e]);
    }
    // Of the vector between the edges' bases: its products with a's edge, and with b's.
    V ab[3][3], p[3][3], q[3][3];
    V s[3][3], t[3][3], skew[3][3], least_skew = one;  // not positive where parallel
    CT_UNROLL
    for (int e = 0; e < 3; ++e) {
      CT_UNROLL
      for (int f = 0; f < 3; ++f) {
        ab[e][f] = Dot(a.along[e], b.along[f]);
        p[e][f] = f == 1 ? on_a[e] - ab[e][0] : on_a[e];
        q[e][f] = e == 1 ? on_b[f] + ab[0][f] : on_b[f];
        const V scale = a.squared[e] * b.squared[f];
        V nn, s_nn;
        if constexpr (careful) {
          const Vec<V> n = Cross(a.along[e], b.along[f]);
          nn = Dot(n, n);
          s_nn = -Dot(Cross(r[kEdgeBase[e]][kEdgeBase[f]], b.along[f]), n);
          skew[e][f] = nn - Fill<V>(kParallel) * scale;
        } else {
          nn = scale - ab[e][f] * ab[e][f];
          s_nn = ab[e][f] * q[e][f] - b.squared[f] * p[e][f];
          skew[e][f] = nn - Fill<V>(kNearlyParallel) * scale;
        }
        if constexpr (IsSingle<V>()) {
          s[e][f] = Clamped(s_nn * Inverse(Most(nn, Fill<V>(kNearlyParallel) * scale)));
        } else {
          least_skew = Least(skew[e][f], least_skew);
          s[e][f] = Clamped(s_nn / nn);
        }
      }
    }
    // A guess need not tell parallel ones.
    const bool any_parallel = !IsSingle<V>() && Any(least_skew <= zero);
    if (any_parallel) {
      // They are as close where one of them starts or ends: A's at its base, or at an end of B's.
      for (int e = 0; e < 3; ++e) {
        for (int f = 0; f < 3; ++f) {
          const auto parallel = skew[e][f] <= zero;
          s[e][f] = Select(parallel, zero, s[e][f]);
          if constexpr (!careful) {
            const Vec<V> n = Cross(a.along[e], b.along[f]);
            const V scale = a.squared[e] * b.squared[f];
            needs_care = needs_care | (parallel & (Dot(n, n) > Fill<V>(kParallel) * scale));
          }
        }
      }
    }
    CT_UNROLL
    for (int e = 0; e < 3; ++e) {
      CT_UNROLL
      for (int f = 0; f < 3; ++f) t[e][f] = Clamped((q[e][f] + s[e][f] * ab[e][f]) * b.inverse[f]);
    }
    CT_UNROLL
    for (int e = 0; e < 3; ++e) {
      CT_UNROLL
      for (int f = 0; f < 3; ++f) s[e][f] = Clamped((t[e][f] * ab[e][f] - p[e][f]) * a.inverse[e]);
    }
    if (any_parallel) {
      for (int e = 0; e < 3; ++e) {
        for (int f = 0; f < 3; ++f) {
          const auto within = (t[e][f] > zero) & (t[e][f] < one);
          s[e][f] = Select((skew[e][f] <= zero) & within, zero, s[e][f]);
        }
      }
    }
    CT_UNROLL
    for (int e = 0; e < 3; ++e) {
      CT_UNROLL
      for (int f = 0; f < 3; ++f) {
        const Vec<V>& base = r[kEdgeBase[e]][kEdgeBase[f]];
        const Vec<V> v = base + s[e][f] * a.along[e] - t[e][f] * b.along[f];
        nearest.Offer(Dot(v, v), s[e][f], t[e][f], Fill<V>(e), Fill<V>(f));
      }
    }
    nearest.spot_a = SpotOnEdge(nearest.spot_a, nearest.s);
    nearest.spot_b = SpotOnEdge(nearest.spot_b, nearest.t);
  }
};

// A facet and the corners of another one.
template <class V, bool careful>
struct CornersOver {
  V height[3], side[3][3];  // of corner i over the plane; of its foot from edge f, inwards
  V squared_distance = Fill<V>(kUnreached);
  V u{}, v{}, corner{};  // the nearest foot within the facet, at (1 - u - v, u, v)

  // r[i][f]: to corner i from corner f of the facet.
  CT_INLINE CornersOver(const Edges<V>& edges, const Vec<V> (&r)[3][3]) {
    const V zero{}, one = Fill<V>(1);
    const Vec<V>&d0 = edges.along[0], &d2 = edges.along[2], n = Cross(d0, d2);
    const V inverse = InverseOrZero(Dot(n, n));
    CT_UNROLL
    for (int f = 0; f < 3; ++f) {
      // The third edge runs against the facet's sense of rotation.
      const Vec<V> m = f == 2 ? Cross(edges.along[f], n) : Cross(n, edges.along[f]);
      CT_UNROLL
      for (int i = 0; i < 3; ++i) side[i][f] = Dot(r[i][kEdgeBase[f]], m);
    }
    CT_UNROLL
    for (int i = 0; i < 3; ++i) {
      height[i] = Dot(r[i][0], n);
      V d2_i, u_i = side[i][2] * inverse, v_i = side[i][0] * inverse;
      if constexpr (careful) {
        u_i = Clamped(u_i);
        v_i = Most(zero, Least(one - u_i, v_i));
        const Vec<V> apart = r[i][0] - u_i * d0 - v_i * d2;
        d2_i = Dot(apart, apart);
      } else {
        d2_i = height[i] * height[i] * inverse;
      }
      const auto within = Least(side[i][0], Least(side[i][1], side[i][2])) > zero;
      d2_i = Select(within, d2_i, Fill<V>(kUnreached));
      const auto better = d2_i < squared_distance;
      squared_distance = Select(better, d2_i, squared_distance);
      u = Select(better, u_i, u);
      v = Select(better, v_i, v);
      corner = Select(better, Fill<V>(kOnCorner + i), corner);
    }
  }

  // Not positive where the plane has corners on both sides, or touches one.
  CT_INLINE V OnBothSides() const { return Least(height[0] * height[1], height[1] * height[2]); }

  // Whether the edge from corner i to corner k pierces the facet; surely, if no rounding between
  // facets of a longest edge can have made it so.
  template <bool surely = false>
  CT_INLINE auto Pierced(int i, int k, V longest = V{}) const {
    const V at_i = Absolute(height[i]), at_k = Absolute(height[k]);
    V x[3];
    CT_UNROLL
    for (int f = 0; f < 3; ++f) x[f] = at_i * side[k][f] + at_k * side[i][f];
    const V inside = Least(x[0], Least(x[1], x[2]));
    const auto through = height[i] * height[k] < V{};
    if constexpr (surely) {
      const V cube = longest * longest * longest, margin = Fill<V>(kProven) * cube;
      return through & (Least(at_i, at_k) > margin) & (inside > margin * cube * longest);
    } else {
      return through & (inside >= V{});
    }
  }
};

// The points where edges of two facets pierce the other one.
template <class V>
struct Piercings {
  V count{};
  Vec<V> first{}, last{};

  // edges: of a facet P whose corners lie over the other one.
  template <bool careful>
  CT_INLINE void Add(const Vec<V> (&P)[3], const Edges<V>& edges,
                     const CornersOver<V, careful>& over) {
    CT_UNROLL
    for (int e = 0; e < 3; ++e) {
      const int i = kEdgeBase[e], k = kEdgeEnd[e];
      const auto pierced = over.Pierced(i, k);
      const V at_i = Absolute(over.height[i]), at_k = Absolute(over.height[k]);
      const Vec<V> point = P[i] + at_i / (at_i + at_k) * edges.along[e];
      first = Select(pierced & (count == V{}), point, first);
      last = Select(pierced, point, last);
      count = count + Select(pierced, Fill<V>(1), V{});
    }
  }

  // Of the segment in which the facets cross; not a number where an edge meets an edge or a corner,
  // so that there are more than two.
  CT_INLINE Vec<V> Middle() const {
    const V half =
        Select(count > Fill<V>(2), Fill<V>(std::numeric_limits<double>::quiet_NaN()), Fill<V>(0.5));
    return half * (first + last);
  }
};

template <class V>
struct Best {
  V s, t, spot_a, spot_b;
  // kNeedsCare where a more careful kernel is to be asked, else 0; from the careful one, where
  // rounding might have made the facets cross.
  V care;
  Vec<V> middle;  // of the segment in which they cross
};

template <class V, bool careful>
CT_INLINE Best<V> FacetDistance(const Vec<V> (&A)[3], const Vec<V> (&B)[3], const Edges<V>& a,
                                const Edges<V>& b) {
  const V zero{};
  Vec<V> to_a[3][3], to_b[3][3];  // from corners of the other facet
  CT_UNROLL
  for (int i = 0; i < 3; ++i) {
    CT_UNROLL
    for (int j = 0; j < 3; ++j) to_a[i][j] = A[i] - B[j], to_b[j][i] = B[j] - A[i];
  }
  const EdgePairs<V, careful> edges(a, b, to_a);
  const CornersOver<V, careful> over_b(b, to_a), over_a(a, to_b);
  Nearest<V> best = edges.nearest;
  best.Offer(over_b.squared_distance, over_b.u, over_b.v, over_b.corner, Fill<V>(kInside));
  best.Offer(over_a.squared_distance, over_a.u, over_a.v, Fill<V>(kInside), over_a.corner);

  // Not when a facet lies on one side of the other's plane; but a facet without area has only a
  // plane made of rounding, so the careful kernel looks in any case.
  if constexpr (IsSingle<V>()) return {best.s, best.t, best.spot_a, best.spot_b, zero, Vec<V>{}};
  auto may_cross = zero == zero;
  if constexpr (!careful) may_cross = Most(over_a.OnBothSides(), over_b.OnBothSides()) <= zero;
  auto crossing = zero != zero, needs_care = edges.needs_care;
  Piercings<V> piercings;
  if (Any(may_cross)) {
    CT_UNROLL
    for (int e = 0; e < 3; ++e) {
      const int i = kEdgeBase[e], k = kEdgeEnd[e];
      crossing = crossing | over_a.Pierced(i, k) | over_b.Pierced(i, k);
    }
    crossing = crossing & may_cross;  // whatever the other lanes hold
  }
  if (Any(crossing)) {
    piercings.Add(A, a, over_b);
    piercings.Add(B, b, over_a);
  }
  if constexpr (careful) {
    if (Any(crossing)) {
      const V longest = SquareRoot(Most(a.SquaredLongest(), b.SquaredLongest()));
      auto surely = zero != zero;
      for (int e = 0; e < 3; ++e) {
        const int i = kEdgeBase[e], k = kEdgeEnd[e];
        surely = surely | over_a.template Pierced<true>(i, k, longest) |
                 over_b.template Pierced<true>(i, k, longest);
      }
      needs_care = crossing & !surely;
    }
  } else {
    needs_care = needs_care & !crossing;
  }
  return {best.s,
          best.t,
          Select(crossing, Fill<V>(kCrossing), best.spot_a),
          Select(crossing, Fill<V>(kCrossing), best.spot_b),
          Select(needs_care, Fill<V>(kNeedsCare), zero),
          piercings.Middle()};
}

template <class V, int lanes, Care care>
void FacetDistancesOf(const double* a, const double* b, const double* X, FacetPairs* pairs) {
  FillUp(lanes, pairs);
  for (int first = 0; first < pairs->count; first += lanes) {
    Vec<V> A[3], B[3];
    LoadPair<V, lanes>(a, b, X, *pairs, first, A, B);
    Best<V> best = FacetDistance<V, care != Care::kFast>(A, B, Edges<V>(A), Edges<V>(B));
    const Spot<V> on_a(A, best.spot_a), on_b(B, best.spot_b);
    if constexpr (care == Care::kFast) {
      const Solution<V, false> solved(on_a, on_b);
      best.s = Select(solved.inside, best.s, solved.s);
      best.t = Select(solved.inside, best.t, solved.t);
    }
    Vec<V> a_point = on_a.Point(best.s, best.s, best.t);
    Vec<V> b_point = on_b.Point(best.t, best.s, best.t);
    const Vec<V> apart = a_point - b_point;
    const V distance = SquareRoot(Dot(apart, apart));
    V needs_care{};
    if constexpr (care == Care::kFast) {
      if (Any(best.care > V{})) {
        const auto certain =
            Certain(A, B, best.spot_a, best.spot_b, best.s, best.t, a_point, b_point, distance);
        needs_care = Select(certain, V{}, best.care);
      }
    } else if constexpr (care == Care::kProven) {
      const auto apart_for_sure = ProvenByPlanes(A, B, b_point, apart, distance);
      const V care_if_apart = Select(apart_for_sure, V{}, Fill<V>(kNeedsCare));
      needs_care = Select(best.spot_a == Fill<V>(kCrossing), best.care, care_if_apart);
    }
    const auto crossing = best.spot_b == Fill<V>(kCrossing);
    if (Any(crossing)) {
      a_point = Select(crossing, best.middle, a_point);
      b_point = Select(crossing, best.middle, b_point);
    }
    StoreMeasured(first, best.spot_a, best.spot_b, needs_care, best.s, best.t, a_point, b_point,
                  apart, distance, pairs);
  }
}

}  // namespace
}  // namespace contact_toolkit
