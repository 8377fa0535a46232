// The distance between triangles, several pairs at once. Included by one source file per
// instruction set, inside an unnamed namespace.
//
// The closest points lie on a corner and an edge (18 cases), inside two edges (9), on a corner and
// inside a facet (6), or the facets cross (an edge pierces a facet: 6). The fast kernel solves edge
// pairs with dot products and takes heights over planes for facet insides; where that loses
// accuracy it asks for the careful one, in which every candidate is a pair of points of the two
// facets whose difference is measured, so that rounding of its parameters enters the distance only
// to second order. The fast kernel passes over nearly parallel edges, and asks unless the answer is
// certain without them.
#pragma once

#include <type_traits>

#include "base/tolerances.h"
#include "kernels/certainty.h"
#include "kernels/facet_lanes.h"
#include "kernels/kernels.h"
#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

constexpr int kEdgeBase[3] = {0, 1, 0};
constexpr int kEdgeEnd[3] = {1, 2, 2};

// The nearest candidate of a kind so far. The two spots are packed into one number, and a kind that
// has no s (or no t) does not carry it.
template <class V, bool has_s, bool has_t>
struct Race {
  V squared_distance = Fill<V>(1e300), s{}, t{}, spots{};

  template <class M>
  CT_INLINE void Offer(M valid, V d2, V s_new, V t_new, int spot_a, int spot_b) {
    Take(valid & (d2 < squared_distance), d2, s_new, t_new, Fill<V>(spot_a + 8 * spot_b));
  }
  CT_INLINE void Offer(V d2, V s_new, V t_new, int spot_a, int spot_b) {
    Take(d2 < squared_distance, d2, s_new, t_new, Fill<V>(spot_a + 8 * spot_b));
  }
  template <bool s_of_other, bool t_of_other>
  CT_INLINE void Challenge(const Race<V, s_of_other, t_of_other>& other) {
    Take(other.squared_distance < squared_distance, other.squared_distance, other.s, other.t,
         other.spots);
  }

 private:
  template <class M>
  CT_INLINE void Take(M better, V d2, V s_new, V t_new, V spots_new) {
    squared_distance = Select(better, d2, squared_distance);
    if constexpr (has_s) s = Select(better, s_new, s);
    if constexpr (has_t) t = Select(better, t_new, t);
    spots = Select(better, spots_new, spots);
  }
};

template <class V>
struct Best {
  V s, t, spot_a, spot_b;
  V care;  // kNeedsCare where the careful kernel is to be asked, else 0
};

template <class V, bool careful>
CT_INLINE Best<V> FacetDistance(const Vec<V> (&A)[3], const Vec<V> (&B)[3]) {
  const V zero{}, one = Fill<V>(1);
  Race<V, false, true> corners_a;
  Race<V, true, false> corners_b;
  Race<V, true, true> edges, insides, best;

  Vec<V> r[3][3];  // from corner j of B to corner i of A
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r[i][j] = A[i] - B[j];
  }
  Vec<V> da[3], db[3];
  V aa[3], bb[3], inv_aa[3], inv_bb[3];
  for (int e = 0; e < 3; ++e) {
    da[e] = A[kEdgeEnd[e]] - A[kEdgeBase[e]];
    db[e] = B[kEdgeEnd[e]] - B[kEdgeBase[e]];
    aa[e] = Dot(da[e], da[e]);
    bb[e] = Dot(db[e], db[e]);
    inv_aa[e] = Select(aa[e] > zero, one / aa[e], zero);
    inv_bb[e] = Select(bb[e] > zero, one / bb[e], zero);
  }
  // r · d for every corner against every edge of the other facet.
  V rb[3][3],
      ra[3][3];  // rb[i][f] = (A_i − base of f) · db_f;  ra[j][e] = (base of e − B_j) · da_e
  for (int i = 0; i < 3; ++i) {
    for (int f = 0; f < 3; ++f) {
      rb[i][f] = Dot(r[i][kEdgeBase[f]], db[f]);
      ra[i][f] = Dot(r[kEdgeBase[f]][i], da[f]);
    }
  }

  // Corners against edges.
  for (int f = 0; f < 3; ++f) {
    for (int i = 0; i < 3; ++i) {
      const V t = Most(zero, Least(one, rb[i][f] * inv_bb[f]));
      const Vec<V> v = r[i][kEdgeBase[f]] - t * db[f];
      corners_a.Offer(Dot(v, v), zero, t, kOnCorner + i, kOnEdge + f);
    }
    for (int j = 0; j < 3; ++j) {
      const V s = Most(zero, Least(one, -ra[j][f] * inv_aa[f]));
      const Vec<V> v = r[kEdgeBase[f]][j] + s * da[f];
      corners_b.Offer(Dot(v, v), s, zero, kOnEdge + f, kOnCorner + j);
    }
  }

  // Edges against edges.
  auto needs_care = zero != zero;
  for (int e = 0; e < 3; ++e) {
    for (int f = 0; f < 3; ++f) {
      const Vec<V>& r0 = r[kEdgeBase[e]][kEdgeBase[f]];
      const V p = ra[kEdgeBase[f]][e], q = rb[kEdgeBase[e]][f];
      const V ab = Dot(da[e], db[f]), scale = aa[e] * bb[f];
      if constexpr (careful) {
        const Vec<V> n = Cross(da[e], db[f]);
        const V nn = Dot(n, n);
        const auto valid = nn > Fill<V>(kParallel) * scale;
        const V inverse = Select(valid, one / nn, zero);
        V s = Most(zero, Least(one, -Dot(Cross(r0, db[f]), n) * inverse));
        V t = Most(zero, Least(one, (q + s * ab) * inv_bb[f]));
        s = Most(zero, Least(one, (t * ab - p) * inv_aa[e]));
        const Vec<V> v = r0 + s * da[e] - t * db[f];
        edges.Offer(valid, Dot(v, v), s, t, kOnEdge + e, kOnEdge + f);
      } else {
        const V nn = scale - ab * ab;
        const V s_nn = ab * q - bb[f] * p, t_nn = aa[e] * q - ab * p;
        auto valid = (s_nn > zero) & (s_nn < nn) & (t_nn > zero) & (t_nn < nn);
        const auto nearly = nn < Fill<V>(kNearlyParallel) * scale;
        if (Any(nearly)) {
          // Parallel edges are as close at one of their corners; in between, dot products fail.
          const Vec<V> n = Cross(da[e], db[f]);
          needs_care = needs_care | (nearly & (Dot(n, n) > Fill<V>(kParallel) * scale));
          valid = valid & !nearly;
        }
        const V inverse = one / nn;
        const V s = s_nn * inverse, t = t_nn * inverse;
        const Vec<V> v = r0 + s * da[e] - t * db[f];
        edges.Offer(valid, Dot(v, v), s, t, kOnEdge + e, kOnEdge + f);
      }
    }
  }

  // Corners against insides. w[i][f]: on which side of edge f the foot of corner i lies.
  const Vec<V> na = Cross(da[0], da[2]), nb = Cross(db[0], db[2]);
  const V nna = Dot(na, na), nnb = Dot(nb, nb);
  const V inv_nna = Select(nna > zero, one / nna, zero);
  const V inv_nnb = Select(nnb > zero, one / nnb, zero);
  V wb[3][3], wa[3][3], hb[3], ha[3];
  for (int f = 0; f < 3; ++f) {
    // Inwards: the third edge runs against the facet's sense of rotation.
    const Vec<V> ma = f == 2 ? Cross(da[f], na) : Cross(na, da[f]);
    const Vec<V> mb = f == 2 ? Cross(db[f], nb) : Cross(nb, db[f]);
    for (int i = 0; i < 3; ++i) {
      wb[i][f] = Dot(r[i][kEdgeBase[f]], mb);
      wa[i][f] = -Dot(r[kEdgeBase[f]][i], ma);
    }
  }
  for (int i = 0; i < 3; ++i) {
    hb[i] = Dot(r[i][0], nb);
    ha[i] = -Dot(r[0][i], na);
    const auto inside_b = (wb[i][0] > zero) & (wb[i][1] > zero) & (wb[i][2] > zero);
    const auto inside_a = (wa[i][0] > zero) & (wa[i][1] > zero) & (wa[i][2] > zero);
    if constexpr (careful) {
      // Barycentric coordinates of the foot on edges 0 and 2, kept within the facet.
      const V u = Most(zero, Least(one, wb[i][2] * inv_nnb));
      const V w = Most(zero, Least(one - u, wb[i][0] * inv_nnb));
      const Vec<V> v = r[i][0] - u * db[0] - w * db[2];
      insides.Offer(inside_b, Dot(v, v), u, w, kOnCorner + i, kInside);
      const V ua = Most(zero, Least(one, wa[i][2] * inv_nna));
      const V va = Most(zero, Least(one - ua, wa[i][0] * inv_nna));
      const Vec<V> v2 = r[0][i] + ua * da[0] + va * da[2];
      insides.Offer(inside_a, Dot(v2, v2), ua, va, kInside, kOnCorner + i);
    } else {
      insides.Offer(inside_b, hb[i] * hb[i] * inv_nnb, wb[i][2] * inv_nnb, wb[i][0] * inv_nnb,
                    kOnCorner + i, kInside);
      insides.Offer(inside_a, ha[i] * ha[i] * inv_nna, wa[i][2] * inv_nna, wa[i][0] * inv_nna,
                    kInside, kOnCorner + i);
    }
  }

  best.Challenge(corners_a);
  best.Challenge(corners_b);
  best.Challenge(edges);
  best.Challenge(insides);

  // Crossing: there is an edge from corner i to corner k that passes the other plane inside the
  // facet. Not when a facet lies on one side of the other's plane; but a facet without area has
  // only a plane made of rounding, so the careful kernel looks in any case.
  auto on_both_sides = zero == zero;
  if constexpr (!careful) {
    on_both_sides = ((hb[0] * hb[1] <= zero) | (hb[1] * hb[2] <= zero)) &
                    ((ha[0] * ha[1] <= zero) | (ha[1] * ha[2] <= zero));
  }
  auto crossing = zero != zero;
  if (Any(on_both_sides)) {
    for (int e = 0; e < 3; ++e) {
      const int i = kEdgeBase[e], k = kEdgeEnd[e];
      auto through_b = hb[i] * hb[k] < zero, through_a = ha[i] * ha[k] < zero;
      const V bi = Absolute(hb[i]), bk = Absolute(hb[k]);
      const V ai = Absolute(ha[i]), ak = Absolute(ha[k]);
      for (int f = 0; f < 3; ++f) {
        through_b = through_b & (bi * wb[k][f] + bk * wb[i][f] >= zero);
        through_a = through_a & (ai * wa[k][f] + ak * wa[i][f] >= zero);
      }
      crossing = crossing | through_a | through_b;
    }
    crossing = crossing & on_both_sides;  // whatever the other lanes hold
  }
  // Rounds spots / 8 down: adding this number leaves no room for a fraction.
  const V no_fraction = Fill<V>(std::is_same_v<V, long double> ? 0x1.8p63 : 0x1.8p52);
  V spot_b = (best.spots * Fill<V>(0.125) - Fill<V>(0.4375) + no_fraction) - no_fraction;
  V spot_a = best.spots - Fill<V>(8) * spot_b;
  spot_a = Select(crossing, Fill<V>(kCrossing), spot_a);
  spot_b = Select(crossing, Fill<V>(kCrossing), spot_b);
  const V care = Select(needs_care & !crossing, Fill<V>(kNeedsCare), zero);
  return {best.s, best.t, spot_a, spot_b, care};
}

// The point of facet P at a spot; `along` is its share of an edge. The ends of edges come out
// exactly.
template <class V>
CT_INLINE Vec<V> PointAt(const Vec<V> (&P)[3], V spot, V along, V s, V t) {
  const auto on_corner1 = spot == Fill<V>(kOnCorner + 1),
             on_corner2 = spot == Fill<V>(kOnCorner + 2);
  const auto on_edge0 = spot == Fill<V>(kOnEdge), on_edge1 = spot == Fill<V>(kOnEdge + 1);
  const auto on_edge2 = spot == Fill<V>(kOnEdge + 2), inside = spot == Fill<V>(kInside);
  const Vec<V> base = Select(on_corner2, P[2], Select(on_corner1 | on_edge1, P[1], P[0]));
  const Vec<V> end = Select(on_edge0 | inside, P[1], P[2]);
  const auto moves = on_edge0 | on_edge1 | on_edge2 | inside;
  const V zero{}, one = Fill<V>(1);
  const V first = Select(inside, s, Select(moves, along, zero));
  const V second = Select(inside, t, zero);
  const Vec<V> point = base + first * (end - base) + second * (P[2] - P[0]);
  return Select(moves & !inside & (along >= one), end, point);
}

template <class V, int lanes, Care care>
void FacetDistancesOf(const double* a, const double* b, const double* X, FacetPairs* pairs) {
  // Fill the last batch up with copies of the last pair.
  for (int k = pairs->count; k % lanes != 0; ++k) {
    pairs->slot_a[k] = pairs->slot_a[pairs->count - 1];
    pairs->slot_b[k] = pairs->slot_b[pairs->count - 1];
  }
  for (int first = 0; first < pairs->count; first += lanes) {
    Vec<V> A[3], b_B[3], B[3];
    LoadFacets<V, lanes>(a, pairs->slot_a + first, A);
    LoadFacets<V, lanes>(b, pairs->slot_b + first, b_B);
    for (int c = 0; c < 3; ++c) B[c] = Posed(X, b_B[c]);
    const Best<V> best = FacetDistance<V, care != Care::kFast>(A, B);
    const Vec<V> a_point = PointAt(A, best.spot_a, best.s, best.s, best.t);
    const Vec<V> b_point = PointAt(B, best.spot_b, best.t, best.s, best.t);
    const Vec<V> apart = a_point - b_point;
    const V distance = SquareRoot(Dot(apart, apart));
    const V inverse = Fill<V>(1) / distance;
    V flagged_spot_a = best.spot_a;
    if constexpr (care == Care::kFast) {
      if (Any(best.care > V{})) {
        const auto certain =
            Certain(A, B, best.spot_a, best.spot_b, best.s, best.t, a_point, b_point, distance);
        flagged_spot_a = flagged_spot_a + Select(certain, V{}, best.care);
      }
    } else if constexpr (care == Care::kProven) {
      const auto proven =
          ProvenByPlanes(A, B, b_point, apart, distance) & (best.spot_a < Fill<V>(kCrossing));
      flagged_spot_a = flagged_spot_a + Select(proven, V{}, Fill<V>(kNeedsCare));
    }
    Store(pairs->distance + first, Select(best.spot_a == Fill<V>(kCrossing), V{}, distance));
    Store(pairs->spot_a + first, flagged_spot_a);
    Store(pairs->spot_b + first, best.spot_b);
    Store(pairs->s + first, best.s);
    Store(pairs->t + first, best.t);
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
}

template <int lanes>
void FacetDistances(const double* a, const double* b, const double* X_AB, Care care,
                    FacetPairs* pairs) {
  using V = typename LanesOf<lanes>::Type;
  switch (care) {
    case Care::kFast:
      return FacetDistancesOf<V, lanes, Care::kFast>(a, b, X_AB, pairs);
    case Care::kCareful:
      return FacetDistancesOf<V, lanes, Care::kCareful>(a, b, X_AB, pairs);
    case Care::kProven:
      return FacetDistancesOf<V, lanes, Care::kProven>(a, b, X_AB, pairs);
  }
}

}  // namespace
}  // namespace contact_toolkit
