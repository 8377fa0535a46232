// Where the area web samples a surface: the facets cut into subtriangles no larger than the node
// spacing, finer along sharp convex edges, whose corners are the nodes. Fixed in the mesh, never by
// the pose. The surface is held in patches, each cut up when it is first touched, so that a large
// body may be sampled finely where it is touched and nowhere else.
//
// An edge is cut in the middle when it is longer than the spacing there: a rule that asks nothing
// but the edge itself, so both facets of an edge agree and the subtriangles conform.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "first_touch.h"
#include "mesh.h"
#include "sphere_tree.h"
#include "vec.h"

namespace contact_toolkit {

// Part of a surface. Nodes on the border to a neighbouring patch exist in both, each with the share
// of the area that lies in its own. So do those on a sharp edge, in the two sides it parts:
// friction of a side then hangs on its own area and load.
struct AreaPatch {
  struct Triangle {
    std::array<std::int32_t, 3> node;
    double area;  // [m²]
  };
  struct Leaf {  // neighbouring triangles
    std::int32_t first, last;
  };
  std::vector<Vec3> nodes;
  std::vector<double> weight;  // [m²] a third of the area of each triangle at the node
  std::vector<Triangle> triangles;
  std::vector<Leaf> leaves;
  SphereTree tree;  // over the leaves
};

class AreaNodes {
 public:
  // `spacing` [m]: the longest edge of a subtriangle; a quarter of it on sharp convex edges,
  // growing linearly to the whole at twice the spacing from them.
  AreaNodes(std::shared_ptr<const CollisionMesh> mesh, double spacing);

  double spacing() const { return spacing_; }
  // Over the patches.
  const SphereTree& tree() const { return tree_; }
  const AreaPatch& patch(std::int32_t index) const;

 private:
  using Corners = std::array<Vec3, 3>;

  void BuildSharpEdges();
  void BuildPatches();
  double SpacingAt(const Vec3& p) const;
  bool Splits(const Vec3& a, const Vec3& b) const;
  template <typename Stop, typename Emit>
  void Cut(const Corners& triangle, const Stop& stop, const Emit& emit) const;
  std::unique_ptr<AreaPatch> MakePatch(std::int32_t index) const;

  std::shared_ptr<const CollisionMesh> mesh_;
  double spacing_;
  std::unique_ptr<Bvh> sharp_edges_;  // as facets that repeat a vertex; null when there are none
  std::vector<Corners> roots_;        // facets, or the parts of large ones, in spatial order
  std::vector<std::int32_t> side_of_root_;  // of the surface, see FindSides()
  std::vector<std::int32_t> first_root_;    // of each patch, and one past the last
  SphereTree tree_;
  std::vector<FirstTouch<AreaPatch>> patches_;
};

}  // namespace contact_toolkit
