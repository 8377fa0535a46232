// The swept kernels for avx2.
#include "simd/swept_kernel.h"

namespace contact_toolkit {

const SweptKernels& Avx2SweptKernels() {
  static constexpr SweptKernels kernels{SweptBoxBounds, SweptFacetCull};
  return kernels;
}

}  // namespace contact_toolkit
