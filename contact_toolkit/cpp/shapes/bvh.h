// A bounding volume hierarchy, eight children wide, over the facets of a mesh. Boxes along axes
// that suit the mesh, in single precision, rounded outwards and taken relative to its centre, one
// array lane a child, so that a box is tested against eight others by one run of vector
// instructions. What is said of boxes and blocks holds in this frame of the hierarchy's own: origin
// and axes. Binned SAH build: Wald, "On fast construction of SAH-based bounding volume
// hierarchies", 2007; wide collapse: Wald, Benthin, Boulos, "Getting rid of packets", 2008.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "math/vec.h"

namespace contact_toolkit {

constexpr int kBvhWidth = 8;

// An inner node's children are nodes; a bottom node's children are single facets. Around each child
// lie a box and a slab, between two planes: a patch of a surface in any attitude fills its box
// badly, and the worse the smaller it is, but the better its slab.
struct alignas(64) BvhNode {
  float center[3][kBvhWidth];     // relative to Bvh::origin; unused lanes repeat lane 0
  float half[3][kBvhWidth];       // half extents; unused lanes hold -infinity, which no test passes
  std::int32_t child[kBvhWidth];  // inner: index into nodes; bottom: slot (see Bvh); unused: -1
  std::int32_t count = 0;
  std::int32_t block = -1;          // index into Bvh::blocks of a bottom node; -1 for an inner node
  float normal[3][kBvhWidth] = {};  // of the slabs: unit, or zero where there is none
  float middle[kBvhWidth] = {};     // they reach from middle - thick to middle + thick along it
  float thick[kBvhWidth] = {};

  bool bottom() const { return block >= 0; }
};

// The facets of one bottom node in single precision, for culling before the exact test.
struct alignas(64) FacetBlock {
  float vertex[3][3][kBvhWidth];  // [corner][axis][lane], relative to Bvh::origin
  float normal[3][kBvhWidth];     // unit, or zero for a facet too thin to be flat to the slack
  float offset[kBvhWidth];        // normal · corner 0
};

struct Bvh {
  Vec3 origin;                     // of the boxes' frame, in the mesh's
  Mat3 axes;                       // ... and its axes: rows, in the mesh's frame
  Vec3 half_extent;                // of the whole mesh about the origin, along the axes
  double size = 0;                 // largest half extent: the scale of rounding errors
  std::vector<BvhNode> nodes;      // nodes[0] is the root
  std::vector<FacetBlock> blocks;  // one for each bottom node
  // Facets in hierarchy order ("slots"): the facet of each slot, its vertices by ascending index
  // (so that the two facets of an edge see it with the same direction, hence the same rounding),
  // and those vertices' coordinates, nine numbers a slot.
  std::vector<std::int32_t> slot_facet;
  std::vector<std::array<std::int32_t, 3>> slot_vertices;
  std::vector<double> slot_coordinates;
  std::vector<std::uint8_t> slot_thin;  // 1 where the fast facet kernel would lose accuracy
  bool any_thin = false;
  int depth = 0;

  std::size_t MemoryBytes() const;
  // A point of the mesh's frame in the boxes'.
  Vec3 Local(const Vec3& p) const { return axes * (p - origin); }
};

// Boxes along the given axes (rows, in the mesh's frame), by default the mesh's own.
Bvh BuildBvh(std::span<const Vec3> vertices, std::span<const std::array<std::int32_t, 3>> faces,
             const Mat3& axes = {});

}  // namespace contact_toolkit
