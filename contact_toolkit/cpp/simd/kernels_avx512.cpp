// The kernels for avx512: 8 lanes of doubles.
#include "simd/box_kernel.h"
#include "simd/facet_kernel.h"
#include "simd/feature_kernel.h"
#include "simd/point_kernel.h"

namespace contact_toolkit {

const Kernels& Avx512Kernels() {
  static constexpr Kernels kernels{
      "avx512",         8,          BoxPairs,          BoxBounds,          PointBoxBounds,
      PointFacetBounds, CullByAxes, FacetDistances<8>, FeatureDistances<8>};
  return kernels;
}

}  // namespace contact_toolkit
