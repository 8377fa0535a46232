// Distance between the convex hulls of two point sets by the Gilbert–Johnson–Keerthi algorithm
// (IEEE J. Robotics and Automation 4(2), 1988). Each step's simplex problem is solved by comparing
// all sub-simplices that contain the newest point, so a sliver costs accuracy, never a wrong
// answer: whatever happens, the witness points lie in the hulls and the lower bound is a separating
// plane's.
#pragma once

#include <array>
#include <limits>
#include <span>

#include "math/vec.h"

namespace contact_toolkit {

enum class GjkStatus {
  kSeparated = 0,       // distance is exact to rounding
  kOverlapping = 1,     // distance 0; p_A == p_B lies in both hulls
  kBeyondBound = 2,     // proven further apart than the bound asked about; no witness points
  kIterationLimit = 3,  // the truth lies between lower_bound and distance
};

struct GjkResult {
  double distance = std::numeric_limits<double>::infinity();  // between the witness points
  double lower_bound = 0;  // of the true distance, up to rounding; 0 when overlapping
  Vec3 p_A, p_B;           // witness points
  Vec3 normal;             // unit, from B towards A, of the plane behind lower_bound; zero if none
  // The witness points as convex combinations of `count` points of each set.
  int count = 0;
  std::array<int, 4> index_a, index_b;
  std::array<double, 4> weight;
  GjkStatus status = GjkStatus::kIterationLimit;
  int iterations = 0;
};

// Both sets need a point. Stops early once the distance is known to exceed `bound`. `guess` is a
// unit vector, from B towards A, along which to look first; a good one saves most of the work.
GjkResult Gjk(std::span<const Vec3> a, std::span<const Vec3> b,
              double bound = std::numeric_limits<double>::infinity(), const Vec3& guess = {});

}  // namespace contact_toolkit
