#include "shapes/mesh.h"

#include <nanobind/nanobind.h>

#include "bindings/arrays.h"

namespace contact_toolkit {
namespace {

using FacesIn = ArrayIn<std::int32_t, Any, Extent<3>>;

void MakeMesh(CollisionMesh* self, PointsIn vertices, FacesIn faces) {
  const std::span points(reinterpret_cast<const Vec3*>(vertices.data()), vertices.shape(0));
  const std::span triples(reinterpret_cast<const CollisionMesh::Triple*>(faces.data()),
                          faces.shape(0));
  const nb::gil_scoped_release release;
  new (self) CollisionMesh(points, triples);
}

nb::dict Defects(nb::handle self) {
  const auto& defects = nb::cast<const CollisionMesh&>(self).defects();
  nb::dict lists;
  lists["open_edges"] = ViewOf<std::int32_t>(defects.open_edges, 0, self);
  lists["non_manifold_edges"] = ViewOf<std::int32_t>(defects.non_manifold_edges, 0, self);
  lists["inconsistent_edges"] = ViewOf<std::int32_t>(defects.inconsistent_edges, 0, self);
  lists["zero_area_facets"] = ViewOf<std::int32_t>(defects.zero_area_facets, 0, self);
  lists["duplicate_facets"] = ViewOf<std::int32_t>(defects.duplicate_facets, 0, self);
  lists["unused_vertices"] = ViewOf<std::int32_t>(defects.unused_vertices, 0, self);
  return lists;
}

nb::dict HierarchyFigures(const CollisionMesh& mesh) {
  const Bvh& bvh = mesh.bvh();
  nb::dict figures;
  figures["nodes"] = bvh.nodes.size();
  figures["bottom_nodes"] = bvh.blocks.size();
  figures["depth"] = bvh.depth;
  figures["facets_per_bottom_node"] =
      static_cast<double>(mesh.faces().size()) / static_cast<double>(bvh.blocks.size());
  figures["bytes"] = bvh.MemoryBytes();
  return figures;
}

// The eight corners each, in the mesh's frame, of the boxes of the children of all nodes at a
// depth; the root's children are depth 0. Bit i of a corner's number is set at the box's upper end
// along the hierarchy's axis i.
Array<double> HierarchyBoxes(const CollisionMesh& mesh, int depth) {
  const Bvh& bvh = mesh.bvh();
  const Mat3 to_mesh = Transpose(bvh.axes);
  std::vector<Vec3> corners;
  std::vector<std::pair<int, int>> stack{{0, 0}};
  while (!stack.empty()) {
    const auto [index, level] = stack.back();
    stack.pop_back();
    const BvhNode& node = bvh.nodes[index];
    for (int k = 0; k < node.count; ++k) {
      if (level == depth) {
        for (int corner = 0; corner < 8; ++corner) {
          Vec3 p;
          for (int i = 0; i < 3; ++i) {
            const double half = node.half[i][k];
            p[i] = node.center[i][k] + (corner >> i & 1 ? half : -half);
          }
          corners.push_back(bvh.origin + to_mesh * p);
        }
      } else if (!node.bottom()) {
        stack.push_back({node.child[k], level + 1});
      }
    }
  }
  return ToNumpy(std::move(corners));
}

}  // namespace

void BindMesh(nb::module_& m) {
  nb::exception<MeshError>(m, "MeshError", PyExc_ValueError);
  using Mesh = CollisionMesh;
  nb::class_<Mesh>(m, "Mesh")
      .def("__init__", &MakeMesh, nb::arg("vertices").noconvert(), nb::arg("faces").noconvert())
      .def_prop_ro("vertices",
                   [](nb::handle self) {
                     return ViewOf<double>(nb::cast<const Mesh&>(self).vertices(), 3, self);
                   })
      .def_prop_ro("faces",
                   [](nb::handle self) {
                     return ViewOf<std::int32_t>(nb::cast<const Mesh&>(self).faces(), 3, self);
                   })
      .def_prop_ro("edges",
                   [](nb::handle self) {
                     return ViewOf<std::int32_t>(nb::cast<const Mesh&>(self).edges(), 2, self);
                   })
      .def_prop_ro("face_edges",
                   [](nb::handle self) {
                     return ViewOf<std::int32_t>(nb::cast<const Mesh&>(self).face_edges(), 3, self);
                   })
      .def_prop_ro("edge_faces",
                   [](nb::handle self) {
                     return ViewOf<std::int32_t>(nb::cast<const Mesh&>(self).edge_faces(), 2, self);
                   })
      .def_prop_ro("welded",
                   [](nb::handle self) {
                     return ViewOf<std::int32_t>(nb::cast<const Mesh&>(self).welded(), 0, self);
                   })
      .def_prop_ro("face_normals",
                   [](nb::handle self) {
                     return ViewOf<double>(nb::cast<const Mesh&>(self).face_normals(), 3, self);
                   })
      .def_prop_ro("defects", &Defects)
      .def_prop_ro("closed", [](const Mesh& mesh) { return mesh.defects().closed(); })
      .def_prop_ro("lower", [](const Mesh& mesh) { return ToNumpy(mesh.lower()); })
      .def_prop_ro("upper", [](const Mesh& mesh) { return ToNumpy(mesh.upper()); })
      .def_prop_ro("diagonal", &Mesh::diagonal)
      .def_prop_ro("volume", &Mesh::volume)
      .def_prop_ro("area", &Mesh::area)
      .def_prop_ro("hierarchy_figures", &HierarchyFigures)
      .def("hierarchy_boxes", &HierarchyBoxes, nb::arg("depth"));
}

}  // namespace contact_toolkit
