// The kernels for any processor: 1 lane of doubles.
#include "simd/box_kernel.h"
#include "simd/facet_kernel.h"
#include "simd/feature_kernel.h"
#include "simd/point_kernel.h"

namespace contact_toolkit {

void ThinFacetDistances(const double* a, const double* b, const double* X_AB, FacetPairs* pairs) {
  FacetDistancesOf<long double, 1, true>(a, b, X_AB, pairs);
}

const Kernels& ScalarKernels() {
  static constexpr Kernels kernels{
      "scalar",         1,          BoxPairs,          BoxBounds,          PointBoxBounds,
      PointFacetBounds, CullByAxes, FacetDistances<1>, FeatureDistances<1>};
  return kernels;
}

}  // namespace contact_toolkit
