#include <bit>

#include "web/area/probed_surface.h"

namespace contact_toolkit {

// The distance from a facet is flat, that from an edge or a vertex curves about it as a cylinder or
// a sphere does: (1 − g gᵀ − u uᵀ)/phi, with u along the edge.
Symmetric3 ProbedSurface::Curvature(const Vec3& p, const FieldValue& value) const {
  if (primitive_) return primitive_.CurvatureAt(p);
  if (value.phi == 0) return {};
  const Bvh& bvh = mesh_->bvh();
  const Vec3& g = value.gradient;
  const Vec3& normal = mesh_->face_normals()[bvh.slot_facet[value.slot]];
  if (g == normal || g == -normal) return {};
  const NearFacet closest{0, value.slot};
  const std::uint8_t corners = FindClosestAmong(bvh, p, {&closest, 1}, 0).corners;
  const int count = std::popcount(corners);
  if (count > 2) return {};
  Vec3 u;
  if (count == 2) {
    const auto& vertices = bvh.slot_vertices[value.slot];
    const int first = std::countr_zero(corners), second = std::bit_width(corners) - 1;
    u = Normalized(mesh_->vertices()[vertices[second]] - mesh_->vertices()[vertices[first]]);
  }
  const double s = 1 / value.phi;
  return {s * (1 - g.x * g.x - u.x * u.x), s * (1 - g.y * g.y - u.y * u.y),
          s * (1 - g.z * g.z - u.z * u.z), -s * (g.x * g.y + u.x * u.y),
          -s * (g.x * g.z + u.x * u.z),    -s * (g.y * g.z + u.y * u.z)};
}

}  // namespace contact_toolkit
