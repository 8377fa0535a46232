// What is known of a pair near a pose, so that it need not be searched afresh there. No answer
// depends on it.
#pragma once

#include <memory>
#include <mutex>

#include "math/vec.h"
#include "web/spring_web.h"

namespace contact_toolkit {

// How far apart a pair is whose boxes are in reach of each other and that bears nothing: while it
// cannot have come near, it is not searched again.
struct Separation {
  int pair = -1;
  Pose X_AB;             // at which it was measured
  double clearance = 0;  // [m] by which every point of one geometry may move relative to the other
};

// What was last remembered of a pair, for all who search it about the same step: the newest is the
// most use.
class LatestMemory {
 public:
  std::shared_ptr<const WebMemory> Get() const {
    const std::lock_guard lock(mutex_);
    return memory_;
  }
  void Set(std::shared_ptr<const WebMemory> memory) {
    const std::lock_guard lock(mutex_);
    memory_.swap(memory);
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const WebMemory> memory_;
};

// Of a pair that bears something, or of one that bears nothing; empty: nothing is known.
struct Surroundings {
  std::shared_ptr<const WebMemory> memory;
  Separation apart;
};

}  // namespace contact_toolkit
