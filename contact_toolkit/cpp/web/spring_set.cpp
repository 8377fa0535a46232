#include "web/spring_set.h"

namespace contact_toolkit {

void SpringSet::clear() {
  Resize(0);
  status = kNominal;
  num_measured = 0;
  slopes.clear();
}

}  // namespace contact_toolkit
