// The distance between triangles, guessed and proven: single precision tells the features on which
// the closest points seem to lie, double precision solves these alone, as the fast kernel does, and
// shows that no others can win there. The rest is left to that kernel, so that what comes out is
// the same with or without. Included by one source file per instruction set, inside an unnamed
// namespace.
#pragma once

#include <utility>

#include "base/tolerances.h"
#include "kernels/certainty.h"
#include "kernels/facet_kernel.h"
#include "kernels/facet_lanes.h"
#include "kernels/facet_points.h"
#include "kernels/kernels.h"
#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

// As many floats as fit a vector, for two of doubles.
template <int lanes>
struct Halves {
  using V = typename LanesOf<lanes>::Type;
  using Half = typename LanesOf<lanes>::Single;
  using Whole = typename LanesOf<2 * lanes>::Single;

  template <int... k>
  CT_INLINE static Whole Join(Half low, Half high, std::integer_sequence<int, k...>) {
    return __builtin_shufflevector(low, high, k...);
  }
  template <int... k>
  CT_INLINE static Half Low(Whole all, std::integer_sequence<int, k...>) {
    return __builtin_shufflevector(all, all, k...);
  }
  template <int... k>
  CT_INLINE static Half High(Whole all, std::integer_sequence<int, k...>) {
    return __builtin_shufflevector(all, all, (lanes + k)...);
  }
  CT_INLINE static Whole Joined(V low, V high) {
    return Join(Converted<Half>(low), Converted<Half>(high),
                std::make_integer_sequence<int, 2 * lanes>());
  }
  CT_INLINE static V Part(Whole all, int part) {
    constexpr std::make_integer_sequence<int, lanes> half;
    return Converted<V>(part == 0 ? Low(all, half) : High(all, half));
  }
};

// The least height along v of the corners of P off the feature at a spot, over that feature.
template <class V>
CT_INLINE V LeastHeight(const Vec<V> (&P)[3], V spot, const Vec<V>& v) {
  const V d1 = Dot(P[1] - P[0], v), d2 = Dot(P[2] - P[0], v), d12 = d2 - d1;
  const V at[6] = {Least(d1, d2), Least(-d1, d12), Least(-d2, -d12), d2, -d1, d1};
  V least = Fill<V>(kUnreached);
  CT_UNROLL
  for (int k = 0; k < 6; ++k) least = Select(spot == Fill<V>(k), at[k], least);
  return least;
}

// Whether the points of a solution are certain to be the fast kernel's, as for features remembered
// from another pose (feature_kernel.h), by bounds of the margins that are quick to tell.
// height [m²]: the least of both facets along the points' difference.
template <class V>
CT_INLINE auto AsTheKernelHasThem(const Spot<V>& a, const Spot<V>& b,
                                  const Solution<V, true>& solved, V height, V squared_distance,
                                  V squared_longest) {
  const V one = Fill<V>(1), far = Fill<V>(kUnreached);
  // (x + y)² ≤ 2 (x² + y²)
  const V squared_span = Fill<V>(2) * (squared_longest + squared_distance);
  const V squared_error = Fill<V>(3 * kCertainAgain) * squared_span;
  // The squared room over the scale, times `scale`.
  const V room_a = Room(solved.s), room_b = Room(solved.t);
  V room = Least(Select(a.on_edge, room_a * room_a * solved.aa, far),
                 Select(b.on_edge, room_b * room_b * solved.bb, far));
  const V room_inside = Most(V{}, Room(solved.s, solved.t));
  room = Select(solved.inside, room_inside * room_inside, room);
  const V nn = Select(solved.both, solved.nn, Select(solved.inside, solved.nn, one));
  const V edges = solved.aa * solved.bb;
  const V scale = Select(solved.both, edges, Select(solved.inside, squared_longest, one));
  const V free = room * nn;
  return (height >= Fill<V>(kCertainAgain * (1 + kFootError * kWorstCondition)) * squared_span) &
         (free >= Fill<V>(16) * squared_error * scale) &
         (height * height * free >= squared_error * squared_error * squared_span * scale) &
         (nn >= Select(solved.both, Fill<V>(kNearlyParallel) * edges, V{})) &
         (squared_distance > Fill<V>(kTooClose * kTooClose) * squared_longest);
}

// What single precision says of a batch.
template <class V>
struct Guess {
  V spot_a, spot_b, squared_longest;
};

// Facets in the halves of a batch.
template <int lanes>
CT_INLINE auto GuessFeatures(const Vec<typename LanesOf<lanes>::Type> (&A)[2][3],
                             const Vec<typename LanesOf<lanes>::Type> (&B)[2][3]) {
  using Split = Halves<lanes>;
  using V = typename Split::V;
  using Single = typename Split::Whole;
  // About a corner of A.
  Vec<Single> near_a[3], near_b[3];
  const auto joined = [&](const Vec<V>(&P)[2][3], int c) {
    const Vec<V> low = P[0][c] - A[0][0], high = P[1][c] - A[1][0];
    return Vec<Single>{Split::Joined(low.x, high.x), Split::Joined(low.y, high.y),
                       Split::Joined(low.z, high.z)};
  };
  CT_UNROLL
  for (int c = 0; c < 3; ++c) near_a[c] = joined(A, c), near_b[c] = joined(B, c);
  const Edges<Single> a(near_a), b(near_b);
  const Best<Single> best = FacetDistance<Single, false>(near_a, near_b, a, b);
  return Guess<Single>{best.spot_a, best.spot_b, Most(a.SquaredLongest(), b.SquaredLongest())};
}

// Solves a guess; leaves kNeedsCare where it is not proven.
template <class V>
CT_INLINE void StoreGuess(const Vec<V> (&A)[3], const Vec<V> (&B)[3], const Guess<V>& guess,
                          int first, FacetPairs* pairs) {
  const Spot<V> a(A, guess.spot_a), b(B, guess.spot_b);
  const Solution<V, true> solved(a, b);
  const Vec<V> a_point = a.Point(solved.s, solved.s, solved.t);
  const Vec<V> b_point = b.Point(solved.t, solved.s, solved.t);
  const Vec<V> apart = a_point - b_point;
  const V squared = Dot(apart, apart);
  const V height = Least(LeastHeight(A, guess.spot_a, apart), LeastHeight(B, guess.spot_b, -apart));
  const auto certain = AsTheKernelHasThem(a, b, solved, height, squared, guess.squared_longest) &
                       (guess.squared_longest > Fill<V>(kLeastSquared));
  StoreMeasured(first, guess.spot_a, guess.spot_b, Select(certain, V{}, Fill<V>(kNeedsCare)),
                solved.s, solved.t, a_point, b_point, apart, SquareRoot(squared), pairs);
}

template <int lanes>
void GuessedFacetDistances(const double* a, const double* b, const double* X, FacetPairs* pairs) {
  using Split = Halves<lanes>;
  using V = typename Split::V;
  FillUp(2 * lanes, pairs);
  for (int first = 0; first < pairs->count; first += 2 * lanes) {
    Vec<V> A[2][3], B[2][3];
    for (int half : {0, 1}) {
      LoadPair<V, lanes>(a, b, X, *pairs, first + half * lanes, A[half], B[half]);
    }
    const auto guess = GuessFeatures<lanes>(A, B);
    for (int half : {0, 1}) {
      const V squared = Split::Part(guess.squared_longest, half) * Fill<V>(1 + kSquaredInSingle);
      StoreGuess<V>(A[half], B[half],
                    {Split::Part(guess.spot_a, half), Split::Part(guess.spot_b, half), squared},
                    first + half * lanes, pairs);
    }
  }
}

template <int lanes>
void FacetDistances(const double* a, const double* b, const double* X_AB, Care care,
                    FacetPairs* pairs) {
  using V = typename LanesOf<lanes>::Type;
  switch (care) {
    case Care::kGuessed:
      if constexpr (lanes > 1) return GuessedFacetDistances<lanes>(a, b, X_AB, pairs);
      [[fallthrough]];  // nothing is gained
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
