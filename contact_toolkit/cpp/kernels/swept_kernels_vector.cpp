// The swept kernels for any processor with vectors of 128 bits.
#include "kernels/prism_kernel.h"
#include "kernels/swept_kernel.h"

namespace contact_toolkit {

const SweptKernels& VectorSweptKernels() {
  static constexpr SweptKernels kernels{SweptBoxBounds, TranslationBounds, TranslationOrders,
                                        SweptFacetCull, CullPrisms<2>};
  return kernels;
}

}  // namespace contact_toolkit
