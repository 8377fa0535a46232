#include "spring_set.h"

namespace contact_toolkit {

void SpringSet::Resize(std::size_t rows) {
  key.resize(rows);
  deformation.resize(rows);
  elastic.resize(rows);
  energy.resize(rows);
  stiffness.resize(rows);
  p_AC.resize(rows);
  normal_A.resize(rows);
  steepness.resize(rows);
  p_ACa.resize(rows);
  p_ACb.resize(rows);
  multiplicity.resize(rows);
}

void SpringSet::clear() {
  Resize(0);
  status = kNominal;
  facet_pairs = 0;
}

}  // namespace contact_toolkit
