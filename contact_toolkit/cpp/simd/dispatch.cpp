#include <atomic>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "simd/kernels.h"

namespace contact_toolkit {
namespace {

// Null when the processor cannot run it or nobody knows the name.
const Kernels* Find(const std::string& name) {
#if CT_X86
  __builtin_cpu_init();
  if (name == "avx512" && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")) {
    return &Avx512Kernels();
  }
  if (name == "avx2" && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    return &Avx2Kernels();
  }
#endif
  return name == "scalar" ? &ScalarKernels() : nullptr;
}

const Kernels* Default() {
  if (const char* wish = std::getenv("CONTACT_TOOLKIT_SIMD")) {
    if (const Kernels* found = Find(wish)) return found;
  }
  for (const char* name : {"avx512", "avx2"}) {
    if (const Kernels* found = Find(name)) return found;
  }
  return &ScalarKernels();
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
  const Kernels* found = Find(name);
  if (found == nullptr) {
    throw std::invalid_argument("no kernels named '" + std::string(name) +
                                "' run on this processor; choose scalar, avx2 or avx512");
  }
  active.store(found, std::memory_order_release);
}

}  // namespace contact_toolkit
