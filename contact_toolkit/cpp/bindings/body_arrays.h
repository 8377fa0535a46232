// Arrays of one entry a body, of which the core knows how many there must be.
#pragma once

#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <string>

#include "bindings/arrays.h"
#include "math/relative_motion.h"

namespace contact_toolkit {

using NumbersIn = nb::ndarray<const double, nb::device::cpu, nb::c_contig>;
static_assert(sizeof(Twist) == 6 * sizeof(double));

// Refuses what is not a finite array of one entry a body; says what was found.
inline void RequireBodies(const NumbersIn& array, const char* name, int bodies,
                          std::initializer_list<std::size_t> entry) {
  bool right = array.ndim() == entry.size() + 1 && array.shape(0) == static_cast<size_t>(bodies);
  std::string wanted = std::to_string(bodies), given;
  std::size_t stride = 1;
  for (std::size_t i = 0; i < entry.size(); ++i) {
    const std::size_t extent = entry.begin()[i];
    right = right && array.shape(i + 1) == extent;
    wanted += ", " + std::to_string(extent);
    stride *= extent;
  }
  if (!right) {
    for (std::size_t i = 0; i < array.ndim(); ++i) {
      given += (i ? ", " : "") + std::to_string(array.shape(i));
    }
    throw nb::value_error((std::string(name) + " must have shape (" + wanted +
                           "), one entry a body; its shape is (" + given + ")")
                              .c_str());
  }
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (std::isfinite(array.data()[i])) continue;
    throw nb::value_error(
        (std::string(name) + " of body " + std::to_string(i / stride) + " is not finite").c_str());
  }
}

}  // namespace contact_toolkit
