#include "web/area/thickness.h"

#include <algorithm>
#include <queue>
#include <vector>

#include "base/tolerances.h"
#include "query/point/point_distance.h"

namespace contact_toolkit {
namespace {

constexpr int kMostCells = 600;  // cells looked into; thin shells have no end of equal candidates
constexpr int kMostShrinks = 30;

// Radius of the largest ball inside that touches the surface where the ball about `center` does:
// shrinks a ball that is too large until nothing else is in it (Ma, Bae and Choi, "3D medial axis
// point approximation using nearest neighbors and the normal field", 2012).
double GrownRadius(const CollisionMesh& mesh, const SignedDistance& at, double most) {
  const Vec3 inwards = -at.gradient;
  double radius = most;
  for (int i = 0; i < kMostShrinks; ++i) {
    const Vec3 center = at.point + radius * inwards;
    const ClosestPoint closest = FindClosestPoint(mesh.bvh(), center, radius * radius, at.slot);
    if (closest.slot < 0) return radius;
    const double gap = radius - std::sqrt(closest.squared_distance);
    const Vec3 chord = closest.point - at.point;
    const double depth = Dot(chord, inwards);
    if (gap <= kThicknessTolerance * radius || !(depth > 0)) return radius - std::max(gap, 0.0);
    radius = std::min(radius, SquaredNorm(chord) / (2 * depth));
  }
  return -at.distance;
}

struct Cell {
  double bound;  // no ball with its centre in the cell is larger
  Vec3 center;
  Vec3 half;
  bool operator<(const Cell& other) const { return bound < other.bound; }
};

}  // namespace

// Best first over boxes: the depth changes no faster than the point moves.
double FindThickness(const Solid& solid) {
  if (!solid.has_inside()) return 0;
  const CollisionMesh& mesh = *solid.mesh();
  const Vec3 half = 0.5 * (mesh.upper() - mesh.lower());
  const double most = std::min({half.x, half.y, half.z});
  double best = 0;
  std::priority_queue<Cell> cells;
  cells.push({most, 0.5 * (mesh.lower() + mesh.upper()), half});
  for (int n = 0; n < kMostCells && !cells.empty(); ++n) {
    const Cell cell = cells.top();
    cells.pop();
    if (cell.bound <= best * (1 + kThicknessTolerance)) break;
    const SignedDistance at = solid.FindSignedDistance(cell.center);
    best = std::max(best, -at.distance);
    if (at.distance < 0) best = std::max(best, GrownRadius(mesh, at, most));
    const double bound = std::min(most, Norm(cell.half) - at.distance);
    if (bound <= best * (1 + kThicknessTolerance)) continue;
    // Cut across the longest side, so that flat bodies get flat cells.
    int axis = 0;
    for (int i = 1; i < 3; ++i) {
      if (cell.half[i] > cell.half[axis]) axis = i;
    }
    Cell child{bound, cell.center, cell.half};
    child.half[axis] *= 0.5;
    for (const double side : {-1.0, 1.0}) {
      child.center[axis] = cell.center[axis] + side * child.half[axis];
      cells.push(child);
    }
  }
  return 2 * best;
}

}  // namespace contact_toolkit
