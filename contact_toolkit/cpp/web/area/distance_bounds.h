// Lower bounds of a probed surface's distance, for culling what cannot touch it. The distance is
// known on lattices of doubling spacing and changes no faster than the point moves.
#pragma once

#include <memory>

#include "math/vec.h"
#include "web/area/lattice_memo.h"
#include "web/area/probed_surface.h"

namespace contact_toolkit {

class DistanceBounds {
 public:
  // `finest` [m]: spacing of the finest lattice.
  DistanceBounds(std::shared_ptr<const ProbedSurface> surface, double finest);

  // Whether the distance certainly exceeds `reach` throughout the ball.
  bool Beyond(const Vec3& center, double radius, double reach) const;

  // [m] The distance of a point is no less; often by far.
  double LowerBound(const Vec3& p) const;

 private:
  // What is known at the lattice point next to a point given from the middle.
  struct Known {
    double distance, squared_offset;
  };
  Known Near(const Vec3& local, double radius) const;
  double SquaredGap(const Vec3& local) const;

  std::shared_ptr<const ProbedSurface> surface_;
  Vec3 middle_, half_;
  double far_;  // [m] outside the box by more than this, no lattice is consulted
  LatticeMemo memo_;
};

}  // namespace contact_toolkit
