// ContactModel: the springs and forces between many bodies, poses and velocities in, one wrench per
// body out. Immutable; shared between threads freely; the same bits on any number of threads.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/recycler.h"
#include "contact/contact_pair.h"
#include "contact/contact_state.h"
#include "contact/forces.h"
#include "contact/linearization.h"
#include "contact/loaded_springs.h"
#include "contact/pair_forces.h"
#include "math/relative_motion.h"

namespace contact_toolkit {

class ContactModel {
 public:
  ContactModel(int num_bodies, std::vector<ContactGeometry> geometries,
               std::vector<ContactPair> pairs, int threads, std::uint64_t id);

  int num_bodies() const { return num_bodies_; }
  // Names what the model is made of: equal models have it in common, in any process; never 0.
  // Springs and states carry it: they mean nothing to another model, whose pairs and webs are
  // others. States before the first step (0) go with any.
  std::uint64_t id() const { return id_; }
  int threads() const { return threads_; }
  const std::vector<ContactGeometry>& geometries() const { return geometries_; }
  const std::vector<ContactPair>& pairs() const { return pairs_; }

  // The loaded springs at one pose a body, in a common frame F. At the very poses of the state's
  // step nothing is computed. The state may be null, here and below.
  std::shared_ptr<const LoadedSprings> Find(std::span<const Pose> X_FB,
                                            const ContactState* state) const;

  // Their forces at one velocity a body, in F. Without a state every contact is new. At the very
  // poses and velocities of the state's step nothing is computed.
  std::shared_ptr<const Forces> ComputeForces(std::shared_ptr<const LoadedSprings> loaded,
                                              std::span<const Twist> V_FB,
                                              const ContactState* state) const;

  // Pair by pair, for callers that move bodies about until forces balance: the loaded springs of
  // one pair, and their forces; `stretches` and `springs` have an entry a spring. FindPair relies
  // on what is known of the pair's surroundings, from the state or in `found`; false where it had
  // to search all the same.
  bool FindPair(int pair, std::span<const Pose> X_FB, const ContactState* state,
                PairSprings* found) const;
  // Sets what is known of the surroundings where this was found, if the way from the last search is
  // so short that it will serve.
  void LookAround(const Pose& last_X_AB, const ContactState* state, PairSprings* found) const;
  PairForce ComputePair(const PairSprings& found, std::span<const Pose> X_FB,
                        std::span<const Twist> V_FB, const ContactState* state,
                        std::span<Stretch> stretches, std::span<SpringForce> springs) const;
  // Both again, and how the forces change; see PairLinearization. The springs must have been found
  // with their slopes wanted.
  PairForce LinearizeFound(const PairSprings& found, std::span<const Pose> X_FB,
                           std::span<const Twist> V_FB, const ContactState* state,
                           Symmetry symmetry, PairLinearization* out) const;
  // Motion of a pair's geometry A relative to its geometry B about A's origin, expressed in A.
  Twist MotionOf(const ContactPair& pair, std::span<const Pose> X_FB,
                 std::span<const Twist> V_FB) const;
  // Forces of which every pair has been computed so: `pairs` and `springs` are set.
  void AddUp(Forces* forces) const;
  std::shared_ptr<LoadedSprings> NewLoadedSprings() const;
  std::shared_ptr<Forces> NewForces() const { return forces_stock_.Take(); }
  // How the forces change with poses and velocities, see Linearization; the state's anchors are
  // held.
  Linearization Linearize(std::span<const Pose> X_FB, std::span<const Twist> V_FB,
                          const ContactState* state, Symmetry symmetry = Symmetry::kNone) const;

  // Where the state's step ended, had the bodies then gone on at their velocities for a while; null
  // before the first step.
  std::shared_ptr<const Forces> Coast(const ContactState& state, double duration) const;

  // A state before the first step, with what overlaps then eased out.
  std::shared_ptr<const ContactState> Eased(Easing easing) const;

  // The state after an accepted step that ended at `time` with `forces`. Taking the same step again
  // changes nothing; a time before the state's own starts afresh.
  std::shared_ptr<const ContactState> Advance(std::shared_ptr<const ContactState> state,
                                              double time,
                                              std::shared_ptr<const Forces> forces) const;

  // The same after a step that was solved implicitly: `forces`, at its end, acted all the way.
  std::shared_ptr<const ContactState> AdvanceImplicitly(std::shared_ptr<const ContactState> state,
                                                        double time,
                                                        std::shared_ptr<const Forces> forces) const;

 private:
  // By what is known of the pair's surroundings; of one that was in contact they are looked at anew
  // where that does not reach so far. False: nothing was found.
  bool RecallPair(const ContactState* state, PairSprings* found) const;
  std::shared_ptr<LoadedSprings> FindLoaded(std::span<const Pose> X_FB, const ContactState* state,
                                            bool with_slopes) const;
  std::shared_ptr<const Forces> EvaluateForces(std::shared_ptr<const LoadedSprings> loaded,
                                               std::span<const Twist> V_FB,
                                               const ContactState* state) const;

  // Pose of a pair's geometry B in its geometry A.
  Pose PoseOf(const ContactPair& pair, std::span<const Pose> X_FB) const;
  // [m] No point of the smaller geometry moves farther, relative to the other.
  double Moved(const ContactPair& pair, const Pose& before_X_AB, const Pose& X_AB) const;
  // Of a pair that bears nothing, moved from one pose to another; clearance 0: not worth knowing.
  Separation SeparationOf(int pair, const Pose& last_X_AB, const Pose& X_AB,
                          const ContactState& state) const;
  // Of the idle pairs, those of which it is worth knowing.
  std::vector<Separation> Separations(const ContactState& state, const LoadedSprings& loaded) const;
  std::shared_ptr<ContactState> Next(const ContactState& state, double time,
                                     std::shared_ptr<const Forces> forces, bool* dragged) const;
  // Powers integrated over the step from the state's to `end`: by Simpson's rule, which takes one
  // more evaluation, unless too little is lost to matter.
  Energetics Lost(const ContactState& state, const Forces& end, double duration) const;
  void AddWrenches(const PairSprings& entry, const PairForce& force, Forces* forces) const;

  std::uint64_t id_;
  int num_bodies_;
  std::vector<ContactGeometry> geometries_;
  std::vector<ContactPair> pairs_;
  int threads_;
  mutable Recycler<LoadedSprings> loaded_stock_;
  mutable Recycler<Forces> forces_stock_;
};

}  // namespace contact_toolkit
