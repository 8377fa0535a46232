// The closest points of two known features, several pairs at once, and whether they are those of
// all facets around. Included by one source file per instruction set, inside an unnamed namespace.
//
// The points must come out as the facet kernel has them, so what it does for the case in question
// is done here operation for operation.
#pragma once

#include <limits>

#include "base/tolerances.h"
#include "kernels/certainty.h"
#include "kernels/facet_kernel.h"
#include "kernels/kernels.h"
#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

// Features of one to three corners: vertices, edges, facets.
template <class V, int corners_a, int corners_b>
struct ClosestPoints {
  Vec<V> a_point, b_point;
  // Of a point on an edge or in a facet: its squared room towards the ends times a scale, and that
  // scale.
  V room_a, scale_a, room_b, scale_b;
  V condition = Fill<V>(1);  // as Margin has it
  decltype(V{} < V{}) regular = V{} == V{};

  CT_INLINE ClosestPoints(const Vec<V> (&A)[3], const Vec<V> (&B)[3], V longest)
      : a_point(A[0]), b_point(B[0]) {
    const V zero{}, one = Fill<V>(1);
    const Vec<V> r = A[0] - B[0];
    if constexpr (corners_a == 1 && corners_b == 1) {
      condition = Fill<V>(kWorstCondition);
    } else if constexpr (corners_a == 1 && corners_b == 2) {
      const Vec<V> db = B[1] - B[0];
      const V bb = Dot(db, db);
      const V t = Clamped(Dot(r, db) * InverseOrZero(bb));
      b_point = B[0] + t * db;
      room_b = Room(t) * Room(t) * bb;
      scale_b = one;
    } else if constexpr (corners_a == 2 && corners_b == 1) {
      const Vec<V> da = A[1] - A[0];
      const V aa = Dot(da, da);
      const V s = Clamped(-Dot(r, da) * InverseOrZero(aa));
      a_point = A[0] + s * da;
      room_a = Room(s) * Room(s) * aa;
      scale_a = one;
    } else if constexpr (corners_a == 2 && corners_b == 2) {
      const Vec<V> da = A[1] - A[0], db = B[1] - B[0];
      const V aa = Dot(da, da), bb = Dot(db, db), ab = Dot(da, db), scale = aa * bb;
      const V p = Dot(r, da), q = Dot(r, db);
      const V nn = scale - ab * ab, inverse = one / nn;
      const V s = (ab * q - bb * p) * inverse, t = (aa * q - ab * p) * inverse;
      a_point = A[0] + s * da;
      b_point = B[0] + t * db;
      regular = (nn >= Fill<V>(kNearlyParallel) * scale) & (Room(s) > zero) & (Room(t) > zero);
      room_a = Room(s) * Room(s) * nn;
      room_b = Room(t) * Room(t) * nn;
      scale_a = bb;
      scale_b = aa;
      condition = scale * inverse;
    } else if constexpr (corners_b == 3) {
      const Vec<V> d0 = B[1] - B[0], d2 = B[2] - B[0];
      const Foot<V> foot(d0, d2, r);
      const V inverse = InverseOrZero(foot.nn), u = foot.u * inverse, w = foot.w * inverse;
      b_point = B[0] + u * d0 + w * d2;
      const V room = Room(u, w);
      regular = room > zero;
      room_b = room * room * foot.nn;
      scale_b = longest * longest;
      condition = scale_b * scale_b / foot.nn;
    } else if constexpr (corners_a == 3) {
      const Vec<V> d0 = A[1] - A[0], d2 = A[2] - A[0];
      const Foot<V> foot(d0, d2, -r);
      const V inverse = InverseOrZero(foot.nn), u = foot.u * inverse, w = foot.w * inverse;
      a_point = A[0] + u * d0 + w * d2;
      const V room = Room(u, w);
      regular = room > zero;
      room_a = room * room * foot.nn;
      scale_a = longest * longest;
      condition = scale_a * scale_a / foot.nn;
    }
  }
};

// Single-precision rows, of which two fill a row of doubles.
CT_INLINE const float* HalfRow(const LaneRow* rows, int index, int first_lane) {
  return reinterpret_cast<const float*>(rows) + kBvhWidth * index + first_lane;
}

// The least of the heights along v over `ways` ways, each over the longest edge [m].
template <int lanes, class V>
CT_INLINE V LeastHeight(const LaneRow* rows, int begin, int ways, int first_lane, const Vec<V>& v) {
  const auto entry = [&](int index) {
    typename LanesOf<lanes>::Single value;
    __builtin_memcpy(&value, HalfRow(rows, index, first_lane), sizeof value);
    return Converted<V>(value);
  };
  V least = Fill<V>(std::numeric_limits<double>::infinity());
  for (int k = 3 * begin; k < 3 * (begin + ways); k += 3) {
    least = Least(Dot(Vec<V>{entry(k), entry(k + 1), entry(k + 2)}, v), least);
  }
  return least;
}

// Measures the lanes from first_lane on; returns the bits of the uncertain ones.
template <int lanes, int corners_a, int corners_b>
CT_INLINE unsigned MeasureFeatures(const LaneRow* rows, const FeatureBlock& block, int first_lane,
                                   const double* X, double touching, FeatureWitness* witnesses) {
  using V = typename LanesOf<lanes>::Type;
  const LaneRow* row = rows + block.first_row;
  const auto next = [&] {
    V value;
    Load((row++)->lane + first_lane, &value);
    return value;
  };
  Vec<V> A[3], B[3];
  for (int c = 0; c < corners_a; ++c) A[c].x = next(), A[c].y = next(), A[c].z = next();
  for (int c = 0; c < corners_b; ++c) {
    Vec<V> p;
    p.x = next(), p.y = next(), p.z = next();
    B[c] = Posed(X, p);
  }
  const V longest = next();
  const ClosestPoints<V, corners_a, corners_b> closest(A, B, longest);

  const Vec<V> v = closest.a_point - closest.b_point;
  const V distance = SquareRoot(Dot(v, v)), inverse = Fill<V>(1) / distance;
  const Margin<V> margin(longest, distance, kCertainAgain);

  V least = Fill<V>(std::numeric_limits<double>::infinity());
  if constexpr (corners_a < 3) least = LeastHeight<lanes>(row, 0, block.ways_a, first_lane, v);
  if constexpr (corners_b < 3) {
    const auto along = [&](int k) { return X[k] * v.x + X[3 + k] * v.y + X[6 + k] * v.z; };
    const Vec<V> v_B{along(0), along(1), along(2)};
    const int begin = corners_a < 3 ? block.ways_a : 0;
    least = Least(LeastHeight<lanes>(row, begin, block.ways_b, first_lane, v_B), least);
  }
  const V height = longest * (least - Fill<V>(kSingleError) * distance);
  auto certain = closest.regular & (distance > Fill<V>(touching)) &
                 (distance > Fill<V>(kTooClose) * longest) &
                 margin.Clears(height, closest.condition);
  if constexpr (corners_a > 1) {
    certain = certain & margin.HasRoom(closest.room_a, closest.scale_a, height);
  }
  if constexpr (corners_b > 1) {
    certain = certain & margin.HasRoom(closest.room_b, closest.scale_b, height);
  }

  alignas(64) double out[10][lanes];
  Store(out[0], closest.a_point.x), Store(out[1], closest.a_point.y);
  Store(out[2], closest.a_point.z), Store(out[3], closest.b_point.x);
  Store(out[4], closest.b_point.y), Store(out[5], closest.b_point.z);
  Store(out[6], inverse * v.x), Store(out[7], inverse * v.y), Store(out[8], inverse * v.z);
  Store(out[9], Select(certain, distance, Fill<V>(-1)));
  unsigned uncertain = 0;
  for (int k = 0; k < lanes; ++k) {
    witnesses[first_lane + k] = {{out[0][k], out[1][k], out[2][k]},
                                 {out[3][k], out[4][k], out[5][k]},
                                 {out[6][k], out[7][k], out[8][k]},
                                 out[9][k]};
    uncertain |= static_cast<unsigned>(out[9][k] < 0) << (first_lane + k);
  }
  return uncertain;
}

template <int lanes, int corners_a, int corners_b>
unsigned MeasureBlock(const LaneRow* rows, const FeatureBlock& block, const double* X,
                      double touching, FeatureWitness* witnesses) {
  unsigned uncertain = 0;
  for (int first = 0; first < kBvhWidth; first += lanes) {
    uncertain |=
        MeasureFeatures<lanes, corners_a, corners_b>(rows, block, first, X, touching, witnesses);
  }
  return uncertain;
}

template <int lanes>
void FeatureDistances(const LaneRow* rows, const FeatureBlock* blocks, std::size_t count,
                      const double* X_AB, double near, double touching, FeatureWitness* witnesses,
                      std::uint8_t* uncertain) {
  for (std::size_t i = 0; i < count; ++i, witnesses += kBvhWidth) {
    const FeatureBlock& block = blocks[i];
    uncertain[i] = 0;
    if (block.nearest > near) {
      for (int k = 0; k < kBvhWidth; ++k) {
        witnesses[k].distance = std::numeric_limits<double>::infinity();
      }
      continue;
    }
    const auto measure = [&](auto kernel) {
      uncertain[i] = static_cast<std::uint8_t>(kernel(rows, block, X_AB, touching, witnesses));
    };
    switch (10 * block.corners_a + block.corners_b) {
      case 11:
        measure(MeasureBlock<lanes, 1, 1>);
        break;
      case 12:
        measure(MeasureBlock<lanes, 1, 2>);
        break;
      case 21:
        measure(MeasureBlock<lanes, 2, 1>);
        break;
      case 22:
        measure(MeasureBlock<lanes, 2, 2>);
        break;
      case 13:
        measure(MeasureBlock<lanes, 1, 3>);
        break;
      case 31:
        measure(MeasureBlock<lanes, 3, 1>);
        break;
    }
  }
}

}  // namespace
}  // namespace contact_toolkit
