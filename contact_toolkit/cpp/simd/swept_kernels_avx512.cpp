// The swept kernels for avx512.
#include "simd/prism_kernel.h"
#include "simd/swept_kernel.h"

namespace contact_toolkit {

const SweptKernels& Avx512SweptKernels() {
  static constexpr SweptKernels kernels{SweptBoxBounds, SweptFacetCull, CullPrisms<8>};
  return kernels;
}

}  // namespace contact_toolkit
