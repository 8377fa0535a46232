// The swept kernels for any processor.
#include "simd/swept_kernel.h"

namespace contact_toolkit {

const SweptKernels& ScalarSweptKernels() {
  static constexpr SweptKernels kernels{SweptBoxBounds, SweptFacetCull};
  return kernels;
}

}  // namespace contact_toolkit
