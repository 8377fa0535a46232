// The kernels for any processor with vectors of 128 bits (SSE2, NEON): 2 lanes of doubles.
#include "kernels/box_kernel.h"
#include "kernels/facet_guess.h"
#include "kernels/feature_kernel.h"
#include "kernels/point_kernel.h"

namespace contact_toolkit {

const Kernels& VectorKernels() {
  static constexpr Kernels kernels{"vector",           2,          BoxPairs,
                                   BoxBounds,          BoxOrders,  PointBoxBounds,
                                   PointFacetBounds,   CullByAxes, FacetDistances<2>,
                                   FeatureDistances<2>};
  return kernels;
}

}  // namespace contact_toolkit
