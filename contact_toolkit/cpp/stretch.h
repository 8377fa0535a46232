// The stretch of each tangential spring of a pair: a function of the pose and of the anchors set at
// the last accepted step. Nothing changes here.
#pragma once

#include <cstdint>
#include <span>

#include "anchors.h"
#include "spring_set.h"
#include "spring_web.h"

namespace contact_toolkit {

struct Stretch {
  Vec3 stretch_A;            // [m] of A's point from B's, in the tangent plane
  bool sliding = true;       // a new contact slides
  std::int32_t anchor = -1;  // index of the anchor whose stretch it is; −1: of none, or a mixture
};

// Fills one entry of `stretches` for each spring.
//
// A spring with an anchor: the offset of the anchor's points within the tangent plane. Both points
// are fixed, so a contact that leans over and comes back has lost nothing.
//
// A spring without: as if anchored where the surfaces stood at the last accepted step
// (`last_X_AB`), times the share of the approach since then that went into deformation, which is
// the stretch since touching had the motion been straight. Without a last step: none.
//
// Where the web carries stretch, feature pairs pass stiffness on to their neighbours as the
// features under a contact change. A spring that gained takes stretch, projected on its tangent
// plane, from neighbours that lost, for no more stiffness than they lost: the sum of the tangential
// forces is kept and no energy is made.
void FindStretches(const SpringWeb& web, const SpringSet& springs, const Pose& X_AB,
                   const AnchorSet* anchors, const Pose* last_X_AB, std::span<Stretch> stretches);

}  // namespace contact_toolkit
