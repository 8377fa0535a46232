// What a contact model asks of a spring web: the loaded springs of one pair of geometries at a
// relative pose. Immutable once built; shared between threads freely.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "math/vec.h"
#include "web/spring_set.h"

namespace contact_toolkit {

// The vertices of the two features behind a spring; −1 where a feature has fewer than three.
struct FeatureVertices {
  std::array<std::int32_t, 3> of_a{-1, -1, -1}, of_b{-1, -1, -1};
};

// What a web keeps of one search to make those at nearby poses cheaper. It never changes an answer.
class WebMemory {
 public:
  virtual ~WebMemory() = default;
};

class SpringWeb {
 public:
  virtual ~SpringWeb() = default;

  // Replaces what `springs` held; rows in an order fixed by the geometries and the pose.
  virtual void FindSprings(const Pose& X_AB, SpringSet* springs) const = 0;

  // The same, to the bit, with the help of what was remembered at a pose nearby; false where it
  // does not reach so far: then nothing is found.
  virtual bool RecallSprings(const WebMemory& /*memory*/, const Pose& /*X_AB*/,
                             SpringSet* /*springs*/) const {
    return false;
  }

  // What helps with several searches near a pose, after a pose with these springs; null: nothing.
  virtual std::shared_ptr<const WebMemory> LookAround(const SpringSet& /*last_springs*/,
                                                      const Pose& /*last_X_AB*/,
                                                      const Pose& /*X_AB*/) const {
    return nullptr;
  }

  // What to remember after a step from one pose to another, where it found these springs: `before`,
  // anew, or nothing (null).
  virtual std::shared_ptr<const WebMemory> Remember(
      const SpringSet& /*springs*/, const Pose& /*last_X_AB*/, const Pose& /*X_AB*/,
      std::shared_ptr<const WebMemory> /*before*/) const {
    return nullptr;
  }

  // [m] A lower bound of how far points of one geometry must move, relative to the other, before a
  // spring is loaded. A poor one does once it is known to be below `enough`.
  virtual double Clearance(const Pose& /*X_AB*/, double /*enough*/) const { return 0; }

  // [m] No spring is loaded while the bounding boxes of the two geometries are farther apart.
  virtual double reach() const = 0;

  // Whether springs are keyed by features, so that a sliding contact passes from one spring to
  // neighbouring ones and takes its tangential stretch along.
  virtual bool CarriesStretch() const { return false; }

  // Of a web that carries stretch.
  virtual FeatureVertices VerticesOf(std::uint64_t /*key*/) const { return {}; }
};

}  // namespace contact_toolkit
