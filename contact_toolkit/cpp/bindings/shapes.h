// Shapes as Python hands them over: a Mesh or Pieces.
#pragma once

#include <nanobind/nanobind.h>

#include "shapes/convex_leaves.h"
#include "shapes/convex_pieces.h"

namespace contact_toolkit {

// A view: the shape must outlive it.
inline ConvexLeaves LeavesOf(nanobind::handle shape) {
  if (nanobind::isinstance<ConvexPieces>(shape)) {
    return nanobind::cast<const ConvexPieces&>(shape).leaves();
  }
  return ConvexLeaves(nanobind::cast<const CollisionMesh&>(shape));
}

}  // namespace contact_toolkit
