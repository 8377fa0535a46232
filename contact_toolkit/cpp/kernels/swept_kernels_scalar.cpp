// The swept kernels for any processor.
#include "kernels/prism_kernel.h"
#include "kernels/swept_kernel.h"

namespace contact_toolkit {

const SweptKernels& ScalarSweptKernels() {
  static constexpr SweptKernels kernels{SweptBoxBounds, TranslationBounds, TranslationOrders,
                                        SweptFacetCull, CullPrisms<1>};
  return kernels;
}

}  // namespace contact_toolkit
