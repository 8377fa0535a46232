// The swept kernels for avx2.
#include "kernels/prism_kernel.h"
#include "kernels/swept_kernel.h"

namespace contact_toolkit {

const SweptKernels& Avx2SweptKernels() {
  static constexpr SweptKernels kernels{SweptBoxBounds, TranslationBounds, TranslationOrders,
                                        SweptFacetCull, CullPrisms<4>};
  return kernels;
}

}  // namespace contact_toolkit
