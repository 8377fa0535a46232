// What the area web asks of the surface it probes: the distance phi and its gradient, signed where
// the mesh bounds a solid. An open surface has no inside: its distance is unsigned, both sides
// push, and the side a point is on is kept apart, so that a passage through the surface is noticed.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "math/vec.h"
#include "query/solid/solid.h"
#include "shapes/mesh.h"
#include "shapes/primitive.h"
#include "web/spring_slopes.h"

namespace contact_toolkit {

struct FieldValue {
  double phi = 0;  // [m]
  Vec3 gradient;   // of phi; unit for the exact field
  int side = 0;    // of an open surface: +1 where the normals point, -1 behind, 0 at its boundary
  std::int32_t slot = -1;  // closest facet, a hint for a neighbouring point
};

class ProbedSurface {
 public:
  // `primitive`: what the mesh stands for, if it is known; then that is what is probed.
  explicit ProbedSurface(std::shared_ptr<const Solid> solid, const Primitive& primitive = {});

  const CollisionMesh& mesh() const { return *mesh_; }
  const Solid& solid() const { return *solid_; }
  const Primitive& primitive() const { return primitive_; }
  // Whether it has an inside.
  bool closed() const { return closed_; }

  FieldValue Probe(const Vec3& p, std::int32_t hint_slot = -1) const;
  // Whether the surface passes within `reach` of p; the value there if it does.
  bool ProbeWithin(const Vec3& p, double reach, std::int32_t hint_slot, FieldValue* value) const;
  // The value where the closest facets are among those given, see FindClosestAmong(); none:
  // searched.
  FieldValue Probe(const Vec3& p, std::span<const NearFacet> facets, double motion) const;

  // [1/m] Second derivatives of phi at p, where `value` was found.
  Symmetric3 Curvature(const Vec3& p, const FieldValue& value) const;

 private:
  FieldValue Exactly(const Vec3& p) const;
  FieldValue ValueAt(const Vec3& p, const ClosestPoint& closest) const;
  bool OnBoundary(const Feature& feature) const;

  std::shared_ptr<const Solid> solid_;
  std::shared_ptr<const CollisionMesh> mesh_;  // the solid's
  Primitive primitive_;
  bool closed_;
  std::vector<std::uint8_t> boundary_vertex_;  // of an open surface
};

}  // namespace contact_toolkit
