// The swept kernels for any processor.
#include "simd/prism_kernel.h"
#include "simd/swept_kernel.h"

namespace contact_toolkit {

const SweptKernels& ScalarSweptKernels() {
  static constexpr SweptKernels kernels{SweptBoxBounds, SweptFacetCull, CullPrisms<1>};
  return kernels;
}

}  // namespace contact_toolkit
