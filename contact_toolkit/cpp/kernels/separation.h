// Whether convex sets may be near others, lane by lane: looks for directions that separate them.
// Included by one source file per instruction set, inside an unnamed namespace.
#pragma once

#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

template <class V>
struct Triangle {
  Vec<V> corner[3];
};

// What a triangle sweeps over in a translation.
template <class V>
struct Prism {
  Triangle<V> begin;
  Vec<V> way;
};

// The hull of a triangle at two poses.
template <class V>
struct TwoPoses {
  Triangle<V> begin, end;
};

template <class V>
CT_INLINE Vec<V> Middle(const Triangle<V>& t) {
  return (V{} + 1.0f / 3) * (t.corner[0] + t.corner[1] + t.corner[2]);
}
template <class V>
CT_INLINE Vec<V> Middle(const Prism<V>& p) {
  return Middle(p.begin) + (V{} + 0.5f) * p.way;
}
template <class V>
CT_INLINE Vec<V> Middle(const TwoPoses<V>& t) {
  return (V{} + 0.5f) * (Middle(t.begin) + Middle(t.end));
}

// Height along v of the corner that lies farthest along v, or against it.
template <bool along, class V>
CT_INLINE V Support(const Triangle<V>& t, const Vec<V>& v, Vec<V>* corner) {
  *corner = t.corner[0];
  V best = Dot(t.corner[0], v);
  for (int c = 1; c < 3; ++c) {
    const V height = Dot(t.corner[c], v);
    const auto better = along ? height > best : height < best;
    best = Select(better, height, best);
    *corner = Select(better, t.corner[c], *corner);
  }
  return best;
}
template <bool along, class V>
CT_INLINE V Support(const Prism<V>& p, const Vec<V>& v, Vec<V>* corner) {
  const V height = Support<along>(p.begin, v, corner), on = Dot(p.way, v);
  const auto better = along ? on > V{} : on < V{};
  *corner = *corner + Select(better, p.way, Vec<V>{});
  return height + Select(better, on, V{});
}

template <bool along, class V>
CT_INLINE V Support(const TwoPoses<V>& t, const Vec<V>& v, Vec<V>* corner) {
  Vec<V> late;
  const V height = Support<along>(t.begin, v, corner), later = Support<along>(t.end, v, &late);
  const auto better = along ? later > height : later < height;
  *corner = Select(better, late, *corner);
  return Select(better, later, height);
}

// One step culls most of what can be culled; a second costs more than it saves.
constexpr int kSteps = 1;

// Lanes in which a and b may be closer than `limit`, judged by their supports along v, about the
// difference of their middles, and after some steps of Frank and Wolfe's method from there towards
// the point of the difference a - b nearest to the origin.
template <class A, class B, class V>
CT_INLINE auto MayBeNear(const A& a, const B& b, Vec<V> v, V limit) {
  auto near = V{} == V{};
  for (int step = 0;; ++step) {
    Vec<V> p, q;
    const V gap = Support<false>(a, v, &p) - Support<true>(b, v, &q);
    near = near & !(gap > limit * SquareRoot(Dot(v, v)));  // where that is inf · 0, keep
    if (step == kSteps) return near;
    const Vec<V> w = p - q - v;
    const V t = -Dot(v, w) / (Dot(w, w) + 1e-30f);
    v = v + Most(V{}, Least(V{} + 1.0f, t)) * w;
  }
}

}  // namespace
}  // namespace contact_toolkit
