#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/tolerances.h"
#include "kernels/kernels.h"
#include "kernels/swept_kernels.h"

namespace contact_toolkit {
namespace {

void ToFloat(const Vec3& v, float out[3]) {
  for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(v[i]);
}
void ToFloat(const Mat3& m, float out[3][3]) {
  for (int i = 0; i < 3; ++i) ToFloat(m.row[i], out[i]);
}
Vec3 Absolute(const Vec3& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }

// The pose of B's boxes' frame in that of A's.
Pose BetweenBoxes(const Bvh& a, const Pose& X_AB, const Bvh& b) {
  return {a.axes * (X_AB.R * Transpose(b.axes)), a.Local(X_AB * b.origin)};
}

// About the size of the mesh's facets [m].
double FacetSize(const Bvh& bvh) {
  return bvh.size / std::sqrt(static_cast<double>(bvh.slot_facet.size()));
}

}  // namespace

SweptCull::SweptCull(const Bvh& a, const Bvh& b, const Motion& motion, const TimeSlice& slice)
    : begin(BetweenBoxes(a, slice.X_begin, b)),
      end(BetweenBoxes(a, slice.X_end, b)),
      middle(a.axes * (slice.R_middle * Transpose(b.axes))),
      axis_B(b.axes * motion.axis_B()) {
  ToFloat(begin.R, R_begin);
  ToFloat(end.R, R_end);
  ToFloat(begin.p, p_begin);
  ToFloat(end.p, p_end);
  ToFloat(middle, R);
  for (int i = 0; i < 3; ++i) ToFloat(Absolute(middle.row[i]), abs_R[i]);
  const double angle = motion.angle() * (slice.end - slice.begin);
  turn = static_cast<float>(0.5 * angle);
  bow = static_cast<float>(0.125 * angle * angle);
  ToFloat(axis_B, axis);
  ToFloat(b.axes * b.origin, from_Bo);
  across_count = 0;
  const Vec3 way = end.p - begin.p;
  // Worth their time only where boxes of facets are passed by.
  const double facet = std::min(FacetSize(a), FacetSize(b));
  const bool passing = Norm(way) > facet;
  for (int i = 0; i < 3 && passing && !motion.rotates(); ++i) {
    const Vec3 normal = Cross(way, Mat3{}.row[i]);
    if (!(Norm(normal) > kCullingSlack * Norm(way))) continue;  // along the axis, or no motion
    const Vec3 u = Normalized(normal);
    ToFloat(u, across[across_count]);
    ToFloat(Absolute(u), abs_across_A[across_count]);
    ToFloat(Absolute(Transpose(middle) * u), abs_across_B[across_count]);
    ++across_count;
  }
  slack =
      static_cast<float>(kCullingSlack * (a.size + b.size + std::max(Norm(begin.p), Norm(end.p)) +
                                          Norm(b.origin) * turn));
  coarse = slack > kCoarse * facet;
}

double SweptCull::SquaredBound(const BvhNode& a, int k, const BvhNode& b, int j) const {
  const Vec3 center_a{a.center[0][k], a.center[1][k], a.center[2][k]};
  const Vec3 half_a{a.half[0][k], a.half[1][k], a.half[2][k]};
  const Vec3 center_b{b.center[0][j], b.center[1][j], b.center[2][j]};
  const Vec3 half_b{b.half[0][j], b.half[1][j], b.half[2][j]};
  const Vec3 from = begin * center_b, to = end * center_b;
  const Vec3 p_BoC{center_b.x + from_Bo[0], center_b.y + from_Bo[1], center_b.z + from_Bo[2]};
  const double swell = turn * Norm(half_b) + bow * Norm(Cross(axis_B, p_BoC));
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    const double reach = half_a[i] + Dot(Absolute(middle.row[i]), half_b) +
                         0.5 * std::abs(to[i] - from[i]) + swell * (1 + kCullingSlack);
    const double gap = std::abs(0.5 * (from[i] + to[i]) - center_a[i]) - reach;
    if (gap > 0) squared += gap * gap;
  }
  return squared * (1 - kTouching);
}

const SweptKernels& ActiveSweptKernels() {
  const std::string_view name = ActiveKernels().name;
#if CT_AVX
  if (name == "avx512") return Avx512SweptKernels();
  if (name == "avx2") return Avx2SweptKernels();
#endif
  if (name == "vector") return VectorSweptKernels();
  return ScalarSweptKernels();
}

}  // namespace contact_toolkit
