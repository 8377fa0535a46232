// Where the area web samples a surface: its flat sides cut into triangles of a few to a side, those
// again and again into parts until they are no larger than the node spacing, finer along sharp
// convex edges. Corners are the nodes. Where the probed body is flat a large triangle is as good as
// its parts, so both stand ready. Fixed in the mesh, never by the pose. The surface is held in
// patches, each cut up when it is first touched, so that a large body may be sampled finely where
// it is touched and nowhere else.
//
// An edge is cut in the middle when it is longer than the spacing there: a rule that asks nothing
// but the edge itself, so both facets of an edge agree and the smallest parts conform.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "base/lazy.h"
#include "math/sphere_tree.h"
#include "math/vec.h"
#include "shapes/mesh.h"
#include "web/area/round_lattice.h"
#include "web/area/triangle_cut.h"

namespace contact_toolkit {

inline Vec3 CenterOf(const Corners& triangle) {
  return (triangle[0] + triangle[1] + triangle[2]) / 3.0;
}
// [m] Of the ball about that.
double RadiusOf(const Corners& triangle);

// Part of a surface. Nodes on the border to a neighbouring patch exist in both, each with the share
// of the area that lies in its own. So do those on a sharp edge, in the two sides it parts:
// friction of a side then hangs on its own area and load.
struct AreaPatch {
  struct Triangle {
    std::array<std::int32_t, 3> node;
    std::int32_t last;  // one past its parts, which follow it; of the smallest, past itself. In a
                        // patch: -1 where there are parts
    double area;        // [m²]
    std::int32_t deeper = -1;  // index into AreaParts::deeper, where its parts are not among these
    // [m²] Of the surface, what falls to each corner: a third of the triangles that meet there, cut
    // as often as this one; where this is one of the smallest, a third of the smallest.
    std::array<double, 3> share{};
  };
  struct Leaf {  // neighbouring triangles
    std::int32_t first, last;
    Sphere around;
    double largest;  // [m] from the middle of a triangle's corners to one of them
  };
  std::vector<Vec3> nodes;
  std::vector<Triangle> triangles;  // the largest ones
  std::vector<Leaf> leaves;
  SphereTree tree;         // over the leaves
  bool has_parts = false;  // of some of the triangles
};

// The parts of a patch's triangles. Nodes have the numbers they have in the patch, then follow
// more. After so many cuts the parts of a part are a patch of their own, cut up when it is first
// touched.
struct AreaParts {
  struct Deeper {
    Corners corners;
    std::int32_t patch;  // a name for it
    Lazy<AreaParts> parts;
    Deeper(const Corners& triangle, std::int32_t name) : corners(triangle), patch(name) {}
  };
  std::int32_t patch;
  std::vector<Vec3> nodes;
  std::vector<AreaPatch::Triangle> triangles;  // each before its parts
  std::vector<std::int32_t> place;             // in there, of each triangle of the patch
  std::deque<Deeper> deeper;
};

class AreaNodes {
 public:
  // `spacing` [m]: the longest edge of a subtriangle; a quarter of it on sharp convex edges,
  // growing linearly to the whole at twice the spacing from them. With a lattice, what the mesh
  // stands for is sampled: parts rise out of it, by no more than it lacks.
  AreaNodes(std::shared_ptr<const CollisionMesh> mesh, double spacing,
            const RoundLattice& round = {});

  double spacing() const { return spacing_; }
  const RoundLattice& round() const { return round_; }
  // Over the patches.
  const SphereTree& tree() const { return tree_; }
  const AreaPatch& patch(std::int32_t index) const;
  const AreaParts& parts(std::int32_t index) const;
  const AreaParts& parts(const AreaParts::Deeper& deeper) const;

 private:
  void BuildSharpEdges();
  void BuildPatches();
  // Exact up to `enough`; what is larger may count as the largest.
  double SpacingAt(const Vec3& p, double enough) const;
  bool Splits(const Vec3& a, const Vec3& b) const;
  bool SplitsRound(const Vec3& a, const Vec3& b) const;
  template <typename Emit>
  bool Cut(const Corners& triangle, const Emit& emit) const;
  class Numbering;
  class AskedEdges;
  std::unique_ptr<AreaPatch> MakePatch(std::int32_t index) const;
  std::unique_ptr<AreaParts> MakeParts(std::int32_t index) const;
  void AddParts(const Corners& triangle, int cuts, Numbering* numbering, AreaParts* parts) const;

  std::shared_ptr<const CollisionMesh> mesh_;
  double spacing_;
  RoundLattice round_;
  std::unique_ptr<Bvh> sharp_edges_;  // as facets that repeat a vertex; null when there are none
  std::vector<Corners> roots_;        // the largest triangles, in spatial order
  std::vector<std::int32_t> side_of_root_;  // of the surface, see FindSides()
  std::vector<std::int32_t> first_root_;    // of each patch, and one past the last
  SphereTree tree_;
  std::vector<Lazy<AreaPatch>> patches_;
  std::vector<Lazy<AreaParts>> parts_;
};

}  // namespace contact_toolkit
