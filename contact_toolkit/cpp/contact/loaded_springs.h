// The loaded springs of a whole model at one configuration; immutable once made.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "contact/surroundings.h"
#include "math/vec.h"
#include "web/spring_set.h"

namespace contact_toolkit {

struct PairSprings {
  int pair = -1;  // index into ContactModel::pairs
  Pose X_FA;      // geometry A in the common frame
  Pose X_AB;      // geometry B in geometry A, the frame of the springs
  SpringSet springs;
  Surroundings known;  // what the next search near here may rely on
};

// Storage is kept between uses: only the first `size` entries of `loaded` mean anything.
struct LoadedSprings : std::enable_shared_from_this<LoadedSprings> {
  std::uint64_t model_id = 0;      // of the ContactModel whose pairs these are
  std::vector<Pose> X_FB;          // the body poses it was found at
  std::vector<PairSprings> pairs;  // pairs with springs or a status, by ascending pair index
  std::size_t size = 0;
  std::vector<int> idle;  // pairs in reach without either, ascending
  std::size_t num_springs = 0;

  void Retire() {}
};

}  // namespace contact_toolkit
