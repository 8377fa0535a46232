// How thick a solid is at its thickest.
#pragma once

#include "query/solid/solid.h"

namespace contact_toolkit {

// Twice the radius of the largest ball inside a solid [m], found to kThicknessTolerance; never more
// than the truth. Zero for a surface without an inside.
double FindThickness(const Solid& solid);

}  // namespace contact_toolkit
