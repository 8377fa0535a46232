// Whether values are the same to the bit: then what was computed from the ones holds for the
// others.
#pragma once

#include <cstring>
#include <span>

namespace contact_toolkit {

// Of structs of doubles alone, so that there is no padding to differ.
template <typename T>
bool SameBits(std::span<const T> a, std::span<const T> b) {
  static_assert(sizeof(T) % sizeof(double) == 0);
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

}  // namespace contact_toolkit
