// How the forces between the bodies of a model change with their poses and velocities, pair by
// pair.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/forces.h"
#include "contact/pair_linearization.h"
#include "math/mat6.h"

namespace contact_toolkit {

// Of each loaded pair, ascending: the wrench on the body of A about that body's origin, in F, and
// how it changes when the body is displaced relative to the other by xi = (rotation, translation of
// its origin) and the relative twist changes by dV, the other body held:
//   dW = −(stiffness · xi + damping · dV)
// as PairLinearization says, but in F and for the body's origin.
struct Linearization {
  std::vector<std::int32_t> pair;
  std::vector<std::array<std::int32_t, 2>> bodies;  // of A, of B
  std::vector<Wrench> wrench;
  std::vector<Mat6> stiffness, damping;

  void Resize(std::size_t pairs);
};

// From geometry A, fixed to a body at p_BG_F from its origin, to that body. `force` on A and
// `w` angular velocity relative to the other, both in F.
PairLinearization ReferToBody(const PairLinearization& of_geometry, const Mat3& R_FG,
                              const Vec3& p_BG_F, const Vec3& force, const Vec3& w);

}  // namespace contact_toolkit
