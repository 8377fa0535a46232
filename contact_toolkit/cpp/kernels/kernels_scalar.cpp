// The kernels for any processor: 1 lane of doubles.
#include "kernels/box_kernel.h"
#include "kernels/facet_guess.h"
#include "kernels/feature_kernel.h"
#include "kernels/point_kernel.h"

namespace contact_toolkit {

void ThinFacetDistances(const double* a, const double* b, const double* X_AB, FacetPairs* pairs) {
  FacetDistancesOf<long double, 1, Care::kCareful>(a, b, X_AB, pairs);
}

const Kernels& ScalarKernels() {
  static constexpr Kernels kernels{"scalar",           1,          BoxPairs,
                                   BoxBounds,          BoxOrders,  PointBoxBounds,
                                   PointFacetBounds,   CullByAxes, FacetDistances<1>,
                                   FeatureDistances<1>};
  return kernels;
}

}  // namespace contact_toolkit
