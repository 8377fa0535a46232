// The swept kernels for avx512.
#include "kernels/prism_kernel.h"
#include "kernels/swept_kernel.h"

namespace contact_toolkit {

const SweptKernels& Avx512SweptKernels() {
  static constexpr SweptKernels kernels{SweptBoxBounds, TranslationBounds, TranslationOrders,
                                        SweptFacetCull, CullPrisms<8>};
  return kernels;
}

}  // namespace contact_toolkit
