// The slopes of the facet web's springs, see SpringSlopes: how the witness points on a pair of
// features move.
#pragma once

#include "shapes/mesh.h"
#include "web/spring_set.h"

namespace contact_toolkit {

// `features` of a spring's key; `exponent` n. Where facets cross, distance and direction say
// nothing of a small displacement: the force is that of the full standoff whatever it is.
void FindFacetSlopes(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                     double exponent, SpringSet* springs);

}  // namespace contact_toolkit
