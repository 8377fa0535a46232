// To single precision, for bounds from below.
#pragma once

#include <cmath>

namespace contact_toolkit {

// No larger than x; infinities stay. By less than a function of the library would take.
inline float RoundedDown(double x) {
  constexpr float kLastPlace = 0x1p-23f, kLeast = 1e-45f;
  const auto rounded = static_cast<float>(x);
  return std::isinf(rounded) ? rounded : rounded - (std::abs(rounded) * kLastPlace + kLeast);
}

}  // namespace contact_toolkit
