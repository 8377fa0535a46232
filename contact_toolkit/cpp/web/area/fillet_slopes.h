// The slopes of the springs of crossing edges, see SpringSlopes and EdgeFillets.
#pragma once

#include "shapes/sharp_edges.h"
#include "web/spring_slopes.h"

namespace contact_toolkit {

// Appends those of one crossing; both edges are in A. `factor` is the constant one of the energy,
// `fading` tells that there are the two rows of a couple.
void AddCrossingSlopes(const StraightEdge& a, const StraightEdge& b, double outwards, double radius,
                       double exponent, double factor, bool fading, SpringSlopes* slopes);

}  // namespace contact_toolkit
