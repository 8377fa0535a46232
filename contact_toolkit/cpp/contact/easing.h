// Easing: how much of the deformation of pairs that overlapped at the start is not felt yet. It
// shrinks evenly, so that the bodies part as slowly as it does and nothing is shot away.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace contact_toolkit {

struct Easing {
  double start = 0, duration = 0;  // [s]
  std::vector<double> depth;       // [m] of each pair at the start; infinite: not felt, ever

  // [m] At the end of a step; −infinity before the first.
  double Withheld(int pair, double time) const {
    const double all = depth[pair];
    if (std::isinf(all) || !(time > start)) return all;
    return all * std::max(0.0, 1 - (time - start) / duration);
  }
};

}  // namespace contact_toolkit
