// ContactModel: the springs and forces between many bodies, poses and velocities in, one wrench per
// body out. Immutable; shared between threads freely; the same bits on any number of threads.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "contact_pair.h"
#include "forces.h"
#include "found.h"
#include "pair_forces.h"
#include "recycler.h"
#include "relative_motion.h"
#include "step_table.h"

namespace contact_toolkit {

class ContactModel {
 public:
  ContactModel(int num_bodies, std::vector<ContactGeometry> geometries,
               std::vector<ContactPair> pairs, int threads);

  int num_bodies() const { return num_bodies_; }

  // The loaded springs at one pose a body, in a common frame F. At the very poses of the table's
  // step nothing is computed. The table may be null, here and below.
  std::shared_ptr<const Found> Find(std::span<const Pose> X_FB, const StepTable* table) const;

  // Their forces at one velocity a body, in F. Without a table every contact is new. At the very
  // poses and velocities of the table's step nothing is computed.
  std::shared_ptr<const Forces> ComputeForces(std::shared_ptr<const Found> found,
                                              std::span<const Twist> V_FB,
                                              const StepTable* table) const;

  // Where the table's step ended, had the bodies then gone on at their velocities for a while; null
  // before the first step.
  std::shared_ptr<const Forces> Coast(const StepTable& table, double duration) const;

  // The table after an accepted step that ended at `time` with `forces`. Taking the same step again
  // changes nothing; a time before the table's own starts afresh.
  std::shared_ptr<const StepTable> Advance(std::shared_ptr<const StepTable> table, double time,
                                           std::shared_ptr<const Forces> forces) const;

 private:
  std::shared_ptr<const Forces> PushBack(std::shared_ptr<const Found> found,
                                         std::span<const Twist> V_FB, const StepTable* table) const;

  // Pose of a pair's geometry B in its geometry A.
  Pose PoseOf(const ContactPair& pair, std::span<const Pose> X_FB) const;
  // Motion of a pair's geometry A relative to its geometry B about A's origin, expressed in A.
  Twist MotionOf(const ContactPair& pair, std::span<const Pose> X_FB,
                 std::span<const Twist> V_FB) const;
  // Powers integrated over the step from the table's to `end`: by Simpson's rule, which takes one
  // more evaluation, unless too little is lost to matter.
  Energetics Lost(const StepTable& table, const Forces& end, double duration) const;
  void AddWrenches(const PairSprings& loaded, const PairForce& force, Forces* forces) const;

  int num_bodies_;
  std::vector<ContactGeometry> geometries_;
  std::vector<ContactPair> pairs_;
  int threads_;
  mutable Recycler<Found> found_stock_;
  mutable Recycler<Forces> forces_stock_;
};

}  // namespace contact_toolkit
