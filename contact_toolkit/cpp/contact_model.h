// ContactModel: the springs and forces between many bodies, poses and velocities in, one wrench per
// body out. Immutable; shared between threads freely; the same bits on any number of threads.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "contact_law.h"
#include "forces.h"
#include "found.h"
#include "mesh.h"
#include "recycler.h"
#include "relative_motion.h"
#include "spring_web.h"
#include "step_table.h"

namespace contact_toolkit {

struct ContactGeometry {
  std::shared_ptr<const CollisionMesh> mesh;
  int body;
  Pose X_BG;
};

struct ContactPair {
  int a, b;  // geometries, on different bodies
  std::shared_ptr<const SpringWeb> web;
  ContactLaw law;
};

class ContactModel {
 public:
  ContactModel(int num_bodies, std::vector<ContactGeometry> geometries,
               std::vector<ContactPair> pairs, int threads);

  int num_bodies() const { return num_bodies_; }
  const std::vector<ContactGeometry>& geometries() const { return geometries_; }
  const std::vector<ContactPair>& pairs() const { return pairs_; }

  // One pose a body, in a common frame F. At the very poses of the table's step nothing is
  // computed.
  std::shared_ptr<const Found> Find(std::span<const Pose> X_FB, const StepTable* table) const;

  // One velocity a body, in F. Without a table every contact is new and slides.
  std::shared_ptr<const Forces> ComputeForces(std::shared_ptr<const Found> found,
                                              std::span<const Twist> V_FB,
                                              const StepTable* table) const;

  // The table after an accepted step that ended at `time`. Taking the same step again changes
  // nothing; a time before the table's own starts afresh.
  std::shared_ptr<const StepTable> Advance(std::shared_ptr<const StepTable> table, double time,
                                           std::shared_ptr<const Forces> forces) const;

 private:
  std::vector<int> PairsInReach(std::span<const Pose> X_FB) const;

  int num_bodies_;
  std::vector<ContactGeometry> geometries_;
  std::vector<ContactPair> pairs_;
  int threads_;
  mutable Recycler<Found> found_stock_;
  mutable Recycler<Forces> forces_stock_;
};

}  // namespace contact_toolkit
