// The kernels for avx2: 4 lanes of doubles.
#include "kernels/box_kernel.h"
#include "kernels/facet_guess.h"
#include "kernels/feature_kernel.h"
#include "kernels/point_kernel.h"

namespace contact_toolkit {

const Kernels& Avx2Kernels() {
  static constexpr Kernels kernels{"avx2",
                                   4,
                                   BoxPairs,
                                   BoxBounds,
                                   BoxOrders,
                                   PointBoxBounds,
                                   PointFacetBounds,
                                   CullByAxes,
                                   FacetDistances<4>,
                                   FeatureDistances<4>};
  return kernels;
}

}  // namespace contact_toolkit
