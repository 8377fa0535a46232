// Nodes that lie farther apart than the closest points so far along the line between these.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/scratch.h"
#include "base/tolerances.h"
#include "math/vec.h"
#include "shapes/bvh.h"
#include "shapes/node_extents.h"

namespace contact_toolkit {

class LineCull {
 public:
  // B keeps its attitude R_AB while its hierarchy's origin goes straight from `start` to `end`,
  // both in A and relative to that of A's hierarchy. rounding [m]: of the coordinates.
  LineCull(const Bvh& a, const Bvh& b, const Mat3& R_AB, const Vec3& start, const Vec3& end,
           double rounding)
      : a_(a),
        b_(b),
        R_AB_(R_AB),
        start_(start),
        end_(end),
        slack_(kCullingSlack * (a.size + b.size) + rounding),
        extents_a_(Extents(0)),
        extents_b_(Extents(1)) {}

  // Whether two nodes stay farther apart than `distance` [m], that of the closest points so far,
  // between which lies the line, from B towards A.
  bool Apart(std::int32_t node_a, std::int32_t node_b, double distance, const Vec3& line) {
    if (distance < stale_below_) Aim(distance, line);
    const double apart = double{extents_a_.Least(node_a)} + extents_b_.Least(node_b) - offset_;
    return apart > distance * length_;
  }

 private:
  static NodeExtents& Extents(int side) {
    return Scratch<std::array<NodeExtents, 2>>([] {})[side];
  }

  // Extents are no larger than the bodies, so single precision does; the way between them is in
  // double.
  void Aim(double distance, const Vec3& line) {
    stale_below_ = distance - kStaleAim * std::min({distance, a_.size, b_.size});
    const Vec3 along = extents_a_.Start(a_, line);
    extents_b_.Start(b_, -(Transpose(R_AB_) * along));
    length_ = Norm(along) * (1 + kTouching);
    offset_ = std::max(Dot(along, start_), Dot(along, end_)) + slack_;
  }

  const Bvh &a_, &b_;
  const Mat3 R_AB_;
  const Vec3 start_, end_;
  const double slack_;
  double stale_below_ = std::numeric_limits<double>::infinity();  // [m] then aim anew
  double offset_ = 0;                                             // [m] of B's origin, and slack
  double length_ = 1;                                             // of the direction as rounded
  NodeExtents &extents_a_, &extents_b_;
};

}  // namespace contact_toolkit
