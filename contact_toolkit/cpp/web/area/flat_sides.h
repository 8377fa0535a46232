// The flat parts of a surface: neighbouring facets in one plane, to rounding, taken as one.
#pragma once

#include <cstdint>
#include <vector>

#include "math/vec.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

struct FlatSides {
  struct Side {
    Vec3 normal;         // unit, outwards
    double offset;       // [m] of the plane: normal · p
    double diameter;     // [m] of its bounding box
    double area = 0;     // [m²]
    bool round = false;  // whether it stands for part of a round wall: it borders on another side
                         // without a crease (see FindCreases())
  };
  std::vector<Side> sides;
  std::vector<std::int32_t> of_facet;  // index into `sides`
};

FlatSides FindFlatSides(const CollisionMesh& mesh);

// Indices into mesh.edges() of the creases between two sides that are not round.
std::vector<std::int32_t> FindCreasesOfFlats(const CollisionMesh& mesh);

}  // namespace contact_toolkit
