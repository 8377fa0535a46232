// Culling of pairs of facets in a translation, several pairs at once and in double precision: what
// stays apart by the least distance itself, along flat walls, single precision cannot tell from
// what comes closer. Included by one source file per instruction set, inside an unnamed namespace.
#pragma once

#include "base/tolerances.h"
#include "kernels/facet_lanes.h"
#include "kernels/separation.h"
#include "kernels/swept_kernels.h"

namespace contact_toolkit {
namespace {

// More steps clear few more pairs and cost as much as GJK on those.
constexpr int kPrismSteps = 4;

// Clears the lanes of `near` in which v separates a from b by more than the square root of
// squared_limit. Returns the point of the difference a - b least far along v.
template <class V, class M>
CT_INLINE Vec<V> Separate(const Triangle<V>& a, const Prism<V>& b, const Vec<V>& v, V squared_limit,
                          M* near) {
  Vec<V> p, q;
  const V gap = Support<false>(a, v, &p) - Support<true>(b, v, &q);
  *near = *near & !((gap > V{}) & (gap * gap > squared_limit * Dot(v, v)));
  return p - q;
}

// On the side that `towards` points to, of any length.
template <class V>
CT_INLINE Vec<V> Normal(const Triangle<V>& t, const Vec<V>& towards) {
  const Vec<V> n = Cross(t.corner[1] - t.corner[0], t.corner[2] - t.corner[0]);
  return Select(Dot(n, towards) < V{}, Vec<V>{} - n, n);
}

// The point nearest to the origin of the triangle v, v + d, v + e if that lies inside, else of its
// side from v to v + d.
template <class V>
CT_INLINE Vec<V> Nearest(const Vec<V>& v, const Vec<V>& d, const Vec<V>& e) {
  const V zero{}, one = Fill<V>(1);
  const V dd = Dot(d, d), de = Dot(d, e), ee = Dot(e, e), vd = Dot(v, d), ve = Dot(v, e);
  const V squared_area = dd * ee - de * de;
  const V s = (de * ve - ee * vd) / squared_area, t = (de * vd - dd * ve) / squared_area;
  const auto inside =
      (squared_area > Fill<V>(kNearlyParallel) * dd * ee) & (s > zero) & (t > zero) & (s + t < one);
  const V on_side = Select(dd > zero, Most(zero, Least(one, -vd / dd)), zero);
  return v + Select(inside, s, on_side) * d + Select(inside, t, zero) * e;
}

template <class V, int lanes>
void CullPrismsOf(const double* a, const double* b, const double* X, const double* way,
                  const double* line, double limit, FacetPairs* pairs) {
  // Fill the last batch up with copies of the last pair.
  for (int k = pairs->count; k % lanes != 0; ++k) {
    pairs->slot_a[k] = pairs->slot_a[pairs->count - 1];
    pairs->slot_b[k] = pairs->slot_b[pairs->count - 1];
  }
  const V squared_limit = Fill<V>(limit * limit);
  for (int first = 0; first < pairs->count; first += lanes) {
    Triangle<V> A, b_B;
    Prism<V> B;
    LoadFacets<V, lanes>(a, pairs->slot_a + first, A.corner);
    LoadFacets<V, lanes>(b, pairs->slot_b + first, b_B.corner);
    for (int c = 0; c < 3; ++c) B.begin.corner[c] = Posed(X, b_B.corner[c]);
    B.way = {Fill<V>(way[0]), Fill<V>(way[1]), Fill<V>(way[2])};
    Vec<V> v = Middle(A) - Middle(B), last = v;
    auto near = V{} == V{};
    Separate(A, B, {Fill<V>(line[0]), Fill<V>(line[1]), Fill<V>(line[2])}, squared_limit, &near);
    Separate(A, B, Normal(A, v), squared_limit, &near);
    Separate(A, B, Normal(B.begin, v), squared_limit, &near);
    // Frank and Wolfe's method, each step over the last two points.
    for (int step = 0; step < kPrismSteps && Any(near); ++step) {
      const Vec<V> next = Separate(A, B, v, squared_limit, &near);
      v = Nearest(v, next - v, last - v);
      last = next;
    }
    Store(pairs->distance + first, Select(near, SquareRoot(Dot(v, v)), Fill<V>(-1)));
  }
}

template <int lanes>
void CullPrisms(const double* a, const double* b, const double* X_AB, const double* way,
                const double* line, double limit, FacetPairs* pairs) {
  CullPrismsOf<typename LanesOf<lanes>::Type, lanes>(a, b, X_AB, way, line, limit, pairs);
}

}  // namespace
}  // namespace contact_toolkit
