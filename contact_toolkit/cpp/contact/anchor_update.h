// The anchors after an accepted step, from those before it and the forces at its end.
#pragma once

#include <memory>
#include <span>

#include "contact/anchors.h"
#include "contact/forces.h"
#include "contact/friction.h"
#include "web/spring_set.h"

namespace contact_toolkit {

// A spring stretched beyond its cone slips: its anchor is dragged until the stretch lies on the
// cone of the dynamic coefficient (return mapping), and it slides until it has stopped or reversed
// within the cone. All other stretches stay as they are, to the bit. Springs that are gone lose
// their anchor. Returns `before` itself when nothing changed.
std::shared_ptr<const AnchorSet> UpdateAnchors(const Friction& friction, const SpringSet& springs,
                                               const Pose& X_AB, std::span<const Stretch> stretches,
                                               std::span<const SpringForce> forces,
                                               std::shared_ptr<const AnchorSet> before);

}  // namespace contact_toolkit
