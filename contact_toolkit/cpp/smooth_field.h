// A once continuously differentiable stand-in for the distance: a tri-quadratic B-spline over a
// lattice, its coefficients the exact distances less an eighth of their second differences. Planes
// and quadratics are reproduced, so curved surfaces stay where they are; convex edges are rounded
// by 0.18 cells and corners by 0.28 (mean over positions and directions; at most 0.26 and 0.38).
//
// Coefficients come in bricks, computed when first touched: a pure function of the mesh and the
// lattice, so the field depends neither on the order of the questions nor on the threads.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "first_touch.h"
#include "probed_surface.h"
#include "vec.h"

namespace contact_toolkit {

class SmoothField {
 public:
  SmoothField(std::shared_ptr<const ProbedSurface> surface, double cell);
  ~SmoothField();

  double cell() const { return cell_; }

  // Remembers the last brick between neighbouring points; one a thread.
  class Cursor;
  FieldValue Probe(const Vec3& p, Cursor* cursor) const;

  // Whether phi exceeds `level` throughout the cell around p, told from what is already computed.
  enum class Above { kYes, kMaybeNot, kUnknown };
  Above IsAbove(const Vec3& p, double level, Cursor* cursor) const;

  // [-] Cells by which the field and the distance differ at most: the distance changes no faster
  // than the point moves, so the spline adds √(3/4), and the second differences an eighth of 6.
  static constexpr double kDeviation = 1.62;
  // [-] Its gradient is no longer than this: the largest of a spline over distances that change no
  // faster than the point moves is 2.13 (by linear programming), diagonally at a cell's corner.
  static constexpr double kSteepest = 2.2;

 private:
  static constexpr int kBrickBits = 3;
  static constexpr int kBrick = 1 << kBrickBits;  // cells a side
  static constexpr int kPoints = kBrick + 2;      // coefficients a side
  static constexpr int kFanoutBits = 4;
  static constexpr int kFanout = 1 << kFanoutBits;  // children a side of the tree over the bricks
  static constexpr int kMostBricks = 1 << 16;       // half a gigabyte; what is beyond is not kept
  struct Brick {
    std::array<double, kPoints * kPoints * kPoints + 1> coefficients;  // one for reading in pairs
    // Of the 27 coefficients over each cell: the spline is a mean of them.
    std::array<float, kBrick * kBrick * kBrick> least;
  };
  struct Branch;

  template <int n>
  void Coefficients(const std::array<std::int32_t, 3>& first, double* coefficients) const;
  void Fill(const std::array<std::int32_t, 3>& brick, Brick* filled) const;
  const Brick* FindBrick(const std::array<std::int32_t, 3>& brick, bool make) const;

  std::shared_ptr<const ProbedSurface> surface_;
  Vec3 origin_;  // lattice point (0, 0, 0)
  double cell_, inverse_cell_;
  int levels_ = 1;  // of branches above the bricks
  std::unique_ptr<Branch> root_;
  mutable std::atomic<int> bricks_{0};
};

class SmoothField::Cursor {
 private:
  friend class SmoothField;
  std::array<std::int32_t, 3> brick_{INT32_MIN, 0, 0};
  const Brick* found_ = nullptr;
};

}  // namespace contact_toolkit
