#include "shapes/convex_pieces.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "base/tolerances.h"

namespace contact_toolkit {
namespace {

// The hierarchy over the pieces' boxes is that over facets which span the boxes' diagonals.
Bvh BuildOverBoxes(std::span<const Vec3> points, std::span<const std::int32_t> first) {
  std::vector<Vec3> corners;
  std::vector<std::array<std::int32_t, 3>> diagonals;
  for (std::size_t i = 0; i + 1 < first.size(); ++i) {
    Vec3 lower = points[first[i]], upper = lower;
    for (const Vec3& p : points.subspan(first[i], first[i + 1] - first[i])) {
      for (int k = 0; k < 3; ++k) {
        lower[k] = std::min(lower[k], p[k]);
        upper[k] = std::max(upper[k], p[k]);
      }
    }
    const auto corner = static_cast<std::int32_t>(corners.size());
    corners.insert(corners.end(), {lower, upper});
    diagonals.push_back({corner, corner + 1, corner});
  }
  Bvh bvh = BuildBvh(corners, diagonals);
  bvh.blocks.clear();  // the diagonals' own say nothing of the pieces
  return bvh;
}

}  // namespace

ConvexPieces::ConvexPieces(std::vector<Vec3> points, std::vector<std::int32_t> first)
    : points_(std::move(points)), first_(std::move(first)) {
  if (first_.size() < 2) throw std::invalid_argument("ConvexPieces needs at least one piece");
  for (int i = 0; i < size(); ++i) {
    const std::string name = "piece " + std::to_string(i);
    if (piece(i).empty()) throw std::invalid_argument(name + " has no point; leave it out");
    for (const Vec3& p : piece(i)) {
      for (int k = 0; k < 3; ++k) {
        if (std::abs(p[k]) <= kMaxCoordinate) continue;  // false for NaN
        throw std::invalid_argument(name +
                                    " has a coordinate that is NaN, infinite or beyond 1e15");
      }
    }
  }
  bvh_ = BuildOverBoxes(points_, first_);
}

}  // namespace contact_toolkit
