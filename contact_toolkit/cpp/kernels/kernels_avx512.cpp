// The kernels for avx512: 8 lanes of doubles.
#include "kernels/box_kernel.h"
#include "kernels/facet_guess.h"
#include "kernels/feature_kernel.h"
#include "kernels/point_kernel.h"

namespace contact_toolkit {

const Kernels& Avx512Kernels() {
  static constexpr Kernels kernels{"avx512",           8,          BoxPairs,
                                   BoxBounds,          BoxOrders,  PointBoxBounds,
                                   PointFacetBounds,   CullByAxes, FacetDistances<8>,
                                   FeatureDistances<8>};
  return kernels;
}

}  // namespace contact_toolkit
