// The sharp convex edges of a mesh, each straight run as one.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/vec.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

// Indices into mesh.edges() of the convex edges with more than 30° between their facets' normals.
std::vector<std::int32_t> FindSharpEdges(const CollisionMesh& mesh);

// The same of convex and concave edges.
std::vector<std::int32_t> FindCreases(const CollisionMesh& mesh);

// Of each facet, a number for the side of the surface it lies in: sharp edges part sides.
std::vector<std::int32_t> FindSides(const CollisionMesh& mesh);

struct StraightEdge {
  std::array<Vec3, 2> ends;
  std::array<Vec3, 2> into;  // unit, in each facet, square to the edge, away from it
};

// Sharp edges with collinear neighbours between the same planes joined.
std::vector<StraightEdge> JoinSharpEdges(const CollisionMesh& mesh);

}  // namespace contact_toolkit
