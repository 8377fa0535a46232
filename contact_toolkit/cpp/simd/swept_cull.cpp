#include <algorithm>
#include <cmath>
#include <string_view>

#include "simd/kernels.h"
#include "simd/swept_kernels.h"
#include "tolerances.h"

namespace contact_toolkit {
namespace {

void ToFloat(const Vec3& v, float out[3]) {
  for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(v[i]);
}
void ToFloat(const Mat3& m, float out[3][3]) {
  for (int i = 0; i < 3; ++i) ToFloat(m.row[i], out[i]);
}
Vec3 Absolute(const Vec3& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }

// About the size of the mesh's facets [m].
double FacetSize(const Bvh& bvh) {
  return bvh.size / std::sqrt(static_cast<double>(bvh.slot_facet.size()));
}

}  // namespace

SweptCull::SweptCull(const Bvh& a, const Bvh& b, const Motion& motion, const TimeSlice& slice) {
  const Vec3 begin = slice.X_begin * b.origin - a.origin, end = slice.X_end * b.origin - a.origin;
  ToFloat(slice.X_begin.R, R_begin);
  ToFloat(slice.X_end.R, R_end);
  ToFloat(begin, p_begin);
  ToFloat(end, p_end);
  ToFloat(slice.R_middle, R);
  for (int i = 0; i < 3; ++i) ToFloat(Absolute(slice.R_middle.row[i]), abs_R[i]);
  const double angle = motion.angle() * (slice.end - slice.begin);
  turn = static_cast<float>(0.5 * angle);
  bow = static_cast<float>(0.125 * angle * angle);
  ToFloat(motion.axis_B(), axis);
  ToFloat(b.origin, from_Bo);
  across_count = 0;
  const Vec3 way = end - begin;
  // Worth their time only where boxes of facets are passed by.
  const bool passing = Norm(way) > std::min(FacetSize(a), FacetSize(b));
  for (int i = 0; i < 3 && passing && !motion.rotates(); ++i) {
    const Vec3 normal = Cross(way, Mat3{}.row[i]);
    if (!(Norm(normal) > kCullingSlack * Norm(way))) continue;  // along the axis, or no motion
    const Vec3 u = Normalized(normal);
    ToFloat(u, across[across_count]);
    ToFloat(Absolute(u), abs_across_A[across_count]);
    ToFloat(Absolute(Transpose(slice.R_middle) * u), abs_across_B[across_count]);
    ++across_count;
  }
  slack = static_cast<float>(
      kCullingSlack * (a.size + b.size + std::max(Norm(begin), Norm(end)) + Norm(b.origin) * turn));
}

const SweptKernels& ActiveSweptKernels() {
#if CT_X86
  const std::string_view name = ActiveKernels().name;
  if (name == "avx512") return Avx512SweptKernels();
  if (name == "avx2") return Avx2SweptKernels();
#endif
  return ScalarSweptKernels();
}

}  // namespace contact_toolkit
