// Which pairs may be in contact, by the bounding boxes of their geometries.
#pragma once

#include <span>
#include <vector>

#include "contact/contact_pair.h"

namespace contact_toolkit {

// Ascending indices of the pairs whose boxes, along the axes of F, come within the web's reach.
std::vector<int> PairsInReach(std::span<const ContactGeometry> geometries,
                              std::span<const ContactPair> pairs, std::span<const Pose> X_FB);

}  // namespace contact_toolkit
