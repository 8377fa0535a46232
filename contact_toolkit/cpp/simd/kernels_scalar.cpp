// The kernels for any processor: 1 lane of doubles.
#include "simd/box_kernel.h"
#include "simd/facet_kernel.h"

namespace contact_toolkit {

const Kernels& ScalarKernels() {
  static constexpr Kernels kernels{"scalar",     1,           BoxPairs,
                                   BoxBounds, CullByPlanes, FacetDistances<1>};
  return kernels;
}

}  // namespace contact_toolkit
