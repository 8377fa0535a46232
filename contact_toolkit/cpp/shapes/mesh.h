// CollisionMesh: a validated triangle mesh with its adjacency, pseudonormals, defects and
// hierarchy.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "math/vec.h"
#include "shapes/bvh.h"

namespace contact_toolkit {

// A mesh no query can make sense of. `what()` names the first bad item and the mend.
struct MeshError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

enum class FeatureKind : std::int32_t { kVertex = 0, kEdge = 1, kFacet = 2 };

// A feature of a mesh, indexed in the mesh's own tables.
struct Feature {
  FeatureKind kind;
  std::int32_t index;
  bool operator==(const Feature&) const = default;
};

// Tolerated defects, each a list of indices (edges: into `edges`; facets: into `faces`).
struct MeshDefects {
  std::vector<std::int32_t> open_edges;          // one facet only: the boundary of an open surface
  std::vector<std::int32_t> non_manifold_edges;  // three facets or more
  std::vector<std::int32_t> inconsistent_edges;  // two facets that run the edge the same way
  std::vector<std::int32_t> zero_area_facets;
  std::vector<std::int32_t> duplicate_facets;  // same three vertices as an earlier facet
  std::vector<std::int32_t> unused_vertices;   // no facet touches them; no query sees them

  // Whether the surface bounds a solid, so that "inside" has a meaning.
  bool closed() const {
    return open_edges.empty() && non_manifold_edges.empty() && inconsistent_edges.empty();
  }
};

// Immutable once built; shared between threads freely.
class CollisionMesh {
 public:
  using Triple = std::array<std::int32_t, 3>;
  using Couple = std::array<std::int32_t, 2>;

  // Welds exactly coincident vertices, builds adjacency and hierarchy, lists the defects.
  // Throws MeshError on no facet, an index out of range, a non-finite or out-of-range coordinate.
  CollisionMesh(std::span<const Vec3> vertices, std::span<const Triple> faces);

  const std::vector<Vec3>& vertices() const { return vertices_; }
  // Facets with the winding they were given, into the welded vertices.
  const std::vector<Triple>& faces() const { return faces_; }
  // Unique edges, lower vertex index first, in lexicographic order.
  const std::vector<Couple>& edges() const { return edges_; }
  // Entry k of facet f is the edge between its vertices k and (k + 1) % 3.
  const std::vector<Triple>& face_edges() const { return face_edges_; }
  // What the facet of a hierarchy slot consists of, as the kernels number it: its sorted vertices,
  // the edges between these, (0,1), (1,2), (0,2), and twice the facet itself.
  using SlotFeatures = std::array<std::int32_t, 8>;
  const std::vector<SlotFeatures>& slot_features() const { return slot_features_; }
  // The first two facets of each edge; -1 where there is none.
  const std::vector<Couple>& edge_faces() const { return edge_faces_; }
  // Index into `vertices` of each input vertex.
  const std::vector<std::int32_t>& welded() const { return welded_; }

  // Unit facet normals by winding (zero for zero-area facets); angle-weighted vertex pseudonormals
  // and edge pseudonormals (sum of the facets' normals), not normalised
  // (Baerentzen and Aanaes, IEEE TVCG 11(3), 2005). Facets without width are looked through: what
  // lies on their other side counts.
  const std::vector<Vec3>& face_normals() const { return face_normals_; }
  const std::vector<Vec3>& edge_normals() const { return edge_normals_; }
  const std::vector<Vec3>& vertex_normals() const { return vertex_normals_; }

  const MeshDefects& defects() const { return defects_; }
  const Bvh& bvh() const { return bvh_; }

  Vec3 lower() const { return lower_; }  // bounding box
  Vec3 upper() const { return upper_; }
  double diagonal() const { return Norm(upper_ - lower_); }
  // Enclosed volume by the divergence theorem [m³]; negative when the winding is inside out.
  double volume() const { return volume_; }
  double area() const { return area_; }

 private:
  void Weld(std::span<const Vec3> vertices, std::span<const Triple> faces);
  void BuildEdges();
  void BuildNormals();
  int LongestEdge(std::int32_t facet) const;
  bool HasNoWidth(std::int32_t facet) const;
  Vec3 NormalAcross(std::int32_t edge, std::int32_t facet, int most) const;
  Vec3 NormalBeyond(std::int32_t facet, std::int32_t edge, int most) const;
  void FindDefects();
  void BuildSlotFeatures();

  std::vector<Vec3> vertices_;
  std::vector<Triple> faces_;
  std::vector<Couple> edges_;
  std::vector<Triple> face_edges_;
  std::vector<SlotFeatures> slot_features_;
  std::vector<Couple> edge_faces_;
  std::vector<std::int32_t> welded_;
  std::vector<Vec3> face_normals_, edge_normals_, vertex_normals_;
  MeshDefects defects_;
  Bvh bvh_;
  Vec3 lower_, upper_;
  double volume_ = 0, area_ = 0;
};

}  // namespace contact_toolkit
