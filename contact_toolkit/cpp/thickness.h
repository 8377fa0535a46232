// How thick a solid is at its thickest.
#pragma once

#include "mesh.h"

namespace contact_toolkit {

// Twice the radius of the largest ball inside a closed mesh [m], found to kThicknessTolerance;
// never more than the truth. Zero for a surface that is not closed.
double FindThickness(const CollisionMesh& mesh);

}  // namespace contact_toolkit
