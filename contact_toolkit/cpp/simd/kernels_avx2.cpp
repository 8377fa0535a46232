// The kernels for avx2: 4 lanes of doubles.
#include "simd/box_kernel.h"
#include "simd/facet_kernel.h"
#include "simd/feature_kernel.h"
#include "simd/point_kernel.h"

namespace contact_toolkit {

const Kernels& Avx2Kernels() {
  static constexpr Kernels kernels{
      "avx2",           4,          BoxPairs,          BoxBounds,          PointBoxBounds,
      PointFacetBounds, CullByAxes, FacetDistances<4>, FeatureDistances<4>};
  return kernels;
}

}  // namespace contact_toolkit
