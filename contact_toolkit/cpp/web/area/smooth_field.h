// A stand-in for the distance that is cheap and, away from sharp edges, once continuously
// differentiable: a tri-quadratic B-spline over a lattice, its coefficients the exact distances
// less an eighth of their second differences. Planes and quadratics are reproduced, so curved
// surfaces stay where they are. About the edges of flat sides, where a spline would bulge
// by hundredths of a cell, it is the exact distance itself, and in between a smooth mean of the
// two.
//
// Coefficients come in bricks, computed when first touched: a pure function of the mesh and the
// lattice, so the field depends neither on the order of the questions nor on the threads.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "base/lazy.h"
#include "math/vec.h"
#include "shapes/bvh.h"
#include "web/area/lattice_memo.h"
#include "web/area/probed_surface.h"

namespace contact_toolkit {

class SmoothField {
 public:
  SmoothField(std::shared_ptr<const ProbedSurface> surface, double cell);
  ~SmoothField();

  double cell() const { return cell_; }

  // Remembers the last brick between neighbouring points; one a thread.
  class Cursor;
  FieldValue Probe(const Vec3& p, Cursor* cursor) const;
  // [1/m] Second derivatives.
  Symmetric3 Curvature(const Vec3& p, Cursor* cursor) const;

  // Whether phi exceeds `level` throughout the cell around p, as far as the values already computed
  // show.
  enum class Above { kYes, kMaybeNot, kUnknown };
  Above IsAbove(const Vec3& p, double level, Cursor* cursor) const;

  // [-] Cells by which the field and the distance differ at most: the distance changes no faster
  // than the point moves, so the spline adds √(3/4), and the second differences an eighth of 6.
  static constexpr double kDeviation = 1.62;
  // [-] Its gradient is no longer than this: the largest of a spline over distances that change no
  // faster than the point moves is 2.13 (by linear programming), diagonally at a cell's corner; and
  // a mean of two fields that differ by kDeviation changes by that with its weight.
  static constexpr double kSteepest = 4;

  // [m] How far one may move from p, where it has this gradient, before it has fallen by `above`.
  double SafeWay(const Vec3& p, const Vec3& gradient, double above) const;

  // [m] Around a point the field is that of the distances within this.
  double support() const { return kSupport * cell_; }

  // Whether the field is the exact distance throughout the ball, by a test that is sure on one side
  // only: false may be said of an exact ball. `doubt` [m]: a ball so much larger may fail the test.
  bool IsExact(const Vec3& center, double radius, double* doubt) const;
  // Whether that may be said of some ball about a point no farther from the center than `way` [m].
  bool MayBeExact(const Vec3& center, double radius, double way) const;

 private:
  static constexpr int kBrickBits = 3;
  static constexpr int kBrick = 1 << kBrickBits;  // cells a side
  static constexpr int kPoints = kBrick + 2;      // coefficients a side
  static constexpr int kFanoutBits = 4;
  static constexpr int kFanout = 1 << kFanoutBits;  // children a side of the tree over the bricks
  static constexpr int kMostBricks = 1 << 16;       // half a gigabyte; what is beyond is not kept
  static constexpr double kSupport = 3.3;           // [-] cells
  // [-] Cells from a sharp edge within which, at lattice points, the exact distance has all the
  // weight, and beyond which it has none. A point is given weights by lattice points within 2.6.
  static constexpr double kWhole = 6, kGone = 8.5, kWeighedFrom = 2.6;
  static_assert(kWhole - kWeighedFrom > kSupport);
  static constexpr double kFloatError = 1e-6;  // [-] of distances kept as floats
  // [-] Over the cell: second derivatives of the spline. Those of a lattice's distances differ by
  // no more than 2 cells, their own second differences by 8: so each of the nine is 2 + 3 × 8 / 8.
  static constexpr double kMostBend = 15;
  static constexpr int kCells = kBrick * kBrick * kBrick;
  static constexpr int kCorners = kPoints * kPoints * kPoints;
  struct Spline {
    std::array<double, kCorners + 1> coefficients;  // one for reading in pairs
    // Of the 27 coefficients over each cell: the spline is a mean of them.
    std::array<float, kCells> least;
  };
  enum class Kind : std::uint8_t { kSpline, kExact, kMixed };
  struct Weights {  // of the exact distance
    std::array<double, kCorners + 1> values;
    std::array<Kind, kCells> kind;  // of the cells
  };
  struct Brick {
    std::unique_ptr<Spline> spline;    // null where all cells are exact
    std::unique_ptr<Weights> weights;  // null where none is
  };
  struct Branch;

  template <int n>
  void Coefficients(const std::array<std::int32_t, 3>& first, double* coefficients) const;
  void FillSpline(const std::array<std::int32_t, 3>& brick, Spline* filled) const;
  bool FillWeights(const std::array<std::int32_t, 3>& brick, Weights* filled) const;
  double WeightAt(const Vec3& p) const;
  static bool AllAre(Kind kind, const Weights& weights);
  // [m] Of a lattice point from the sharp edges, or a little more.
  double SharpDistance(const LatticeMemo::Point& point) const;
  // [m] No more than that of a point, asked of a lattice of about that spacing.
  double LeastSharpDistance(const Vec3& p, double spacing) const;
  // Whether the ball is all beyond where the exact distance has weight; false may be said of one.
  bool IsSpline(const Vec3& center, double radius) const;
  FieldValue ProbeExact(const Vec3& p, Cursor* cursor) const;
  struct Cell;
  void Find(const Vec3& p, Cursor* cursor, Cell* cell) const;
  const Brick* FindBrick(const std::array<std::int32_t, 3>& brick, bool make) const;

  std::shared_ptr<const ProbedSurface> surface_;
  Vec3 origin_;  // lattice point (0, 0, 0)
  double cell_, inverse_cell_;
  std::unique_ptr<Bvh> sharp_edges_;  // as facets that repeat a vertex; null when there are none
  std::unique_ptr<LatticeMemo> sharp_distances_;
  int levels_ = 1;  // of branches above the bricks
  std::unique_ptr<Branch> root_;
  mutable std::atomic<int> bricks_{0};
};

class SmoothField::Cursor {
 private:
  friend class SmoothField;
  std::array<std::int32_t, 3> brick_{INT32_MIN, 0, 0};
  const Brick* found_ = nullptr;
  std::int32_t slot_ = -1;  // of the last exact value
};

}  // namespace contact_toolkit
