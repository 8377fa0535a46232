// The stretch of each tangential spring of a pair: a function of the pose and of the anchors set at
// the last accepted step. Nothing changes here.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact/anchors.h"
#include "web/spring_set.h"
#include "web/spring_web.h"

namespace contact_toolkit {

struct Stretch {
  Vec3 stretch_A;            // [m] of A's point from B's, in the tangent plane
  bool sliding = true;       // a new contact slides
  std::int32_t anchor = -1;  // index of the anchor whose stretch it is; −1: of none, or a mixture
};

// A stretch before projection on the tangent plane, in its parts: held + share · weight · since.
// Linearizing needs them, as each changes with the pose in its own way.
struct StretchSource {
  Vec3 held;               // [m] offset of anchor points, a mean of several with their weights
  Vec3 held_point;         // [m] of A's, from Ao; likewise
  double held_weight = 0;  // [-] the sum of the weights
  Vec3 since;              // [m] offset since the last accepted step
  double weight = 0;       // [-]
  double share = 1;        // [-] of the approach that went into deformation
};

struct StretchSources {
  std::vector<StretchSource> rows;  // of each spring
  Mat3 turned;  // how A's axes, in which B is held, have turned since the last accepted step
};

// Fills one entry of `stretches` for each spring; and `sources` if it is given.
//
// A spring with an anchor has a point fixed in A and a point fixed in B, which coincided when they
// stuck: its stretch is the offset between them, projected on the tangent plane. As both are fixed,
// a contact that leans over and comes back ends with the stretch it began with.
//
// A spring without an anchor touched during this step. Its stretch is the tangential motion since
// the last accepted step (`last_X_AB`) times (deformation / approach since then): for a straight
// motion, the tangential motion since the surfaces met. Without a last step it is zero.
//
// Where the web carries stretch, feature pairs pass stiffness on to their neighbours as the
// features under a contact change. A spring that gained takes stretch, projected on its tangent
// plane, from neighbours that lost, for no more stiffness than they lost: the sum of the tangential
// forces is kept and no energy is made.
void FindStretches(const SpringWeb& web, const SpringSet& springs, const Pose& X_AB,
                   const AnchorSet* anchors, const Pose* last_X_AB, std::span<Stretch> stretches,
                   StretchSources* sources = nullptr);

}  // namespace contact_toolkit
