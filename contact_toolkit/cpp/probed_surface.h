// What the area web asks of the surface it probes: the distance phi and its gradient, signed where
// the mesh is closed. An open surface has no inside: its distance is unsigned, both sides push, and
// the side a point is on is told separately so that a passage can be noticed.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mesh.h"
#include "point_distance.h"
#include "vec.h"

namespace contact_toolkit {

struct FieldValue {
  double phi = 0;  // [m]
  Vec3 gradient;   // of phi; unit for the exact field
  int side = 0;    // of an open surface: +1 where the normals point, -1 behind, 0 at its boundary
  std::int32_t slot = -1;  // closest facet, a hint for a neighbouring point
};

class ProbedSurface {
 public:
  explicit ProbedSurface(std::shared_ptr<const CollisionMesh> mesh);

  const CollisionMesh& mesh() const { return *mesh_; }
  bool closed() const { return closed_; }

  FieldValue Probe(const Vec3& p, std::int32_t hint_slot = -1) const;
  // Whether the surface passes within `reach` of p; the value there if it does.
  bool ProbeWithin(const Vec3& p, double reach, std::int32_t hint_slot, FieldValue* value) const;
  // The value where the closest facets are among those given, see FindClosestAmong(); none:
  // searched.
  FieldValue Probe(const Vec3& p, std::span<const NearFacet> facets, double motion) const;

 private:
  FieldValue ValueAt(const Vec3& p, const ClosestPoint& closest) const;
  bool OnBoundary(const Feature& feature) const;

  std::shared_ptr<const CollisionMesh> mesh_;
  bool closed_;
  std::vector<std::uint8_t> boundary_vertex_;  // of an open surface
};

}  // namespace contact_toolkit
