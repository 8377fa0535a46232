// Which way the facets of a mesh must be wound, and which of them count, for the mesh to bound a
// solid: what a hole-free surface with doubled, turned or stray facets means.
#pragma once

#include <cstdint>
#include <vector>

#include "shapes/mesh.h"

namespace contact_toolkit {

struct Winding {
  // Of each facet: 1 as given, -1 turned round, 0 without a part in the boundary.
  std::vector<std::int8_t> turn;
  // Of each facet: the sheet of facets joined by edges that two facets share, the cluster of sheets
  // that share any edge; -1 for facets left out.
  std::vector<std::int32_t> sheet, cluster;
  std::int32_t num_sheets = 0, num_clusters = 0;
  std::vector<std::uint8_t> sheet_branches;  // whether three facets or more meet at its rim
  std::vector<std::int32_t> duplicates, collapsed, turned;  // facets, ascending
  std::vector<std::uint8_t> cluster_open;                   // whether an edge of it is not balanced
  bool balanced = true;  // every edge is run as often one way as the other: nothing is open
};

// A facet given several times counts once; sheets keep the winding of most of their area; where
// three facets or more meet, sheets that leave the rim balanced are chosen, so that a wall between
// two chambers, or a fin, has no part. What is most of its cluster always has. Facets without width
// that close nothing are left out.
Winding FindWinding(const CollisionMesh& mesh);

}  // namespace contact_toolkit
