#include <atomic>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "kernels/kernels.h"

namespace contact_toolkit {
namespace {

// Null when the processor cannot run it or nobody knows the name.
const Kernels* Find(const std::string& name) {
#if CT_AVX
  __builtin_cpu_init();
  if (name == "avx512" && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")) {
    return &Avx512Kernels();
  }
  if (name == "avx2" && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    return &Avx2Kernels();
  }
#endif
  if (name == "vector") return &VectorKernels();
  return name == "scalar" ? &ScalarKernels() : nullptr;
}

const Kernels& Named(const std::string& name, const std::string& by) {
  if (const Kernels* found = Find(name)) return *found;
  throw std::invalid_argument(by + ": no kernels named '" + name +
                              "' run on this processor; choose scalar, vector, avx2 or avx512");
}

const Kernels* Default() {
  if (const char* wish = std::getenv("CONTACT_TOOLKIT_SIMD")) {
    return &Named(wish, "environment variable CONTACT_TOOLKIT_SIMD");
  }
  for (const char* name : {"avx512", "avx2"}) {
    if (const Kernels* found = Find(name)) return found;
  }
  return &VectorKernels();
}

std::atomic<const Kernels*> active{nullptr};

}  // namespace

const Kernels& ActiveKernels() {
  const Kernels* kernels = active.load(std::memory_order_acquire);
  if (kernels == nullptr) {
    kernels = Default();
    active.store(kernels, std::memory_order_release);
  }
  return *kernels;
}

void SelectKernels(const char* name) {
  active.store(&Named(name, "SelectKernels"), std::memory_order_release);
}

}  // namespace contact_toolkit
