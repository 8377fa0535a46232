#include "contact/contact_arrays.h"

namespace contact_toolkit {

ContactArrays ListContacts(const Forces& forces) {
  ContactArrays list;
  std::size_t row = 0;
  for (std::size_t i = 0; i < forces.loaded->size; ++i) {
    const PairSprings& entry = forces.loaded->pairs[i];
    const SpringSet& springs = entry.springs;
    const Pose& X_FA = entry.X_FA;
    for (std::size_t s = 0; s < springs.size(); ++s, ++row) {
      const SpringForce& force = forces.springs[row];
      list.pair.push_back(entry.pair);
      list.key.push_back(springs.key[s]);
      list.p_FC.push_back(X_FA * springs.p_AC[s]);
      list.p_FCa.push_back(X_FA * springs.p_ACa[s]);
      list.p_FCb.push_back(X_FA * springs.p_ACb[s]);
      list.normal_F.push_back(X_FA.R * springs.normal_A[s]);
      list.deformation.push_back(springs.deformation[s]);
      list.rate.push_back(force.rate);
      list.stiffness.push_back(springs.stiffness[s]);
      list.normal_force.push_back(force.normal * springs.steepness[s]);
      list.friction_force_F.push_back(X_FA.R * force.friction_A);
      list.multiplicity.push_back(springs.multiplicity[s]);
      list.anchored.push_back(force.anchored);
      list.status.push_back(springs.status);
    }
  }
  return list;
}

}  // namespace contact_toolkit
