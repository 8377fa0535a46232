// The swept kernels for avx2.
#include "simd/prism_kernel.h"
#include "simd/swept_kernel.h"

namespace contact_toolkit {

const SweptKernels& Avx2SweptKernels() {
  static constexpr SweptKernels kernels{SweptBoxBounds, SweptFacetCull, CullPrisms<4>};
  return kernels;
}

}  // namespace contact_toolkit
