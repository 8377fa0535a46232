// The contacts of a whole model as one structure of arrays, in the common frame: for output only.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/forces.h"
#include "math/vec.h"

namespace contact_toolkit {

struct ContactArrays {
  std::vector<std::int32_t> pair;
  std::vector<std::uint64_t> key;
  std::vector<Vec3> p_FC, p_FCa, p_FCb;
  std::vector<Vec3> normal_F;  // unit, from B towards A
  std::vector<double> deformation, rate;
  std::vector<double> stiffness;       // [N/m] at most, along normal_F
  std::vector<double> normal_force;    // on A along normal_F
  std::vector<Vec3> friction_force_F;  // on A
  std::vector<std::int32_t> multiplicity;
  std::vector<std::uint8_t> anchored;
  std::vector<std::int32_t> status;  // of the pair, see ContactStatus
};

ContactArrays ListContacts(const Forces& forces);

}  // namespace contact_toolkit
