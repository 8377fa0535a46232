// A once continuously differentiable stand-in for the distance: a tri-quadratic B-spline whose
// coefficients are the exact distances at the points of a lattice. It equals the distance to a
// plane, rounds convex edges by 0.225 and corners by 0.35 cells, and differs from the distance by
// less than 0.87 cells anywhere.
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
  struct Cursor {
    std::array<std::int32_t, 3> brick{INT32_MIN, 0, 0};
    const double* coefficients = nullptr;
  };
  FieldValue Probe(const Vec3& p, Cursor* cursor) const;

  // [-] cells by which the field and the distance differ at most: the second moment of the basis.
  static constexpr double kDeviation = 0.8661;

 private:
  static constexpr int kBrick = 8;             // cells a side
  static constexpr int kPoints = kBrick + 2;   // coefficients a side
  static constexpr int kFanout = 16;           // children a side of the tree over the bricks
  static constexpr int kMostBricks = 1 << 16;  // half a gigabyte; what is beyond is not kept
  struct Brick {
    std::array<double, kPoints * kPoints * kPoints> coefficients;
  };
  struct Branch;

  void FillBrick(const std::array<std::int32_t, 3>& brick, Brick* filled) const;
  const Brick* FindBrick(const std::array<std::int32_t, 3>& brick) const;
  Vec3 LatticePoint(std::int32_t i, std::int32_t j, std::int32_t k) const;

  std::shared_ptr<const ProbedSurface> surface_;
  Vec3 origin_;  // lattice point (0, 0, 0)
  double cell_;
  int levels_ = 1;  // of branches above the bricks
  std::unique_ptr<Branch> root_;
  mutable std::atomic<int> bricks_{0};
};

}  // namespace contact_toolkit
