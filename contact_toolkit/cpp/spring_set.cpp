#include "spring_set.h"

namespace contact_toolkit {

void SpringSet::clear() {
  key.clear();
  deformation.clear();
  elastic.clear();
  energy.clear();
  stiffness.clear();
  p_AC.clear();
  gradient_A.clear();
  p_ACa.clear();
  p_ACb.clear();
  multiplicity.clear();
  status = kNominal;
  facet_pairs = 0;
}

}  // namespace contact_toolkit
