// How far apart a pair is whose boxes are in reach of each other and that bears nothing: while it
// cannot have come near, it is not searched again.
#pragma once

#include "math/vec.h"

namespace contact_toolkit {

struct Separation {
  int pair;
  Pose X_AB;         // at which it was measured
  double clearance;  // [m] by which every point of one geometry may move relative to the other
};

}  // namespace contact_toolkit
