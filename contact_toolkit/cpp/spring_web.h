// What a contact model asks of a spring web: the loaded springs of one pair of geometries at a
// relative pose. Immutable once built; shared between threads freely.
#pragma once

#include "spring_set.h"
#include "vec.h"

namespace contact_toolkit {

class SpringWeb {
 public:
  virtual ~SpringWeb() = default;

  // Replaces what `springs` held; rows in an order fixed by the geometries and the pose.
  virtual void FindSprings(const Pose& X_AB, SpringSet* springs) const = 0;

  // [m] No spring is loaded while the bounding boxes of the two geometries are farther apart.
  virtual double reach() const = 0;
};

}  // namespace contact_toolkit
