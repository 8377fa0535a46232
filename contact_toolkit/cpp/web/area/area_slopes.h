// The slopes of the area web's springs, see SpringSlopes: nodes that share a triangle load each
// other.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "math/vec.h"
#include "web/area/clipped_slope.h"
#include "web/spring_set.h"

namespace contact_toolkit {

// R m Rᵀ
Symmetric3 Rotated(const Mat3& R, const Symmetric3& m);

// How the integrals at three nodes change with the deformations at three.
struct LoadCoupling {
  std::array<std::int32_t, 3> loaded, deepened;
  Coupling slope;
};

// Sets `slopes.elastic` from the couplings, and the row among the springs (−1: none) of what they
// speak of.
void FindElasticSlopes(std::span<const LoadCoupling> couplings, std::span<const std::int32_t> row,
                       double stiffness, SpringSet* springs);

}  // namespace contact_toolkit
