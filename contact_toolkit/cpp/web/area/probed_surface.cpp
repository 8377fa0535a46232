#include "web/area/probed_surface.h"

#include <cmath>
#include <limits>
#include <utility>

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

ProbedSurface::ProbedSurface(std::shared_ptr<const Solid> solid, const Primitive& primitive)
    : solid_(std::move(solid)),
      mesh_(solid_->mesh()),
      primitive_(primitive),
      closed_(solid_->has_inside()) {
  if (closed_) return;
  boundary_vertex_.resize(mesh_->vertices().size(), 0);
  const MeshDefects& defects = mesh_->defects();
  // Where more than two facets meet or their windings disagree, sides have no meaning either.
  for (const auto* edges :
       {&defects.open_edges, &defects.non_manifold_edges, &defects.inconsistent_edges}) {
    for (const std::int32_t edge : *edges) {
      for (const std::int32_t v : mesh_->edges()[edge]) boundary_vertex_[v] = 1;
    }
  }
}

bool ProbedSurface::OnBoundary(const Feature& feature) const {
  switch (feature.kind) {
    case FeatureKind::kVertex:
      return boundary_vertex_[feature.index];
    case FeatureKind::kEdge: {
      // Also an inner edge that joins two boundary vertices: an unknown side is only noticed later.
      const auto [a, b] = mesh_->edges()[feature.index];
      return boundary_vertex_[a] && boundary_vertex_[b];
    }
    default:
      return false;
  }
}

FieldValue ProbedSurface::Probe(const Vec3& p, std::int32_t hint_slot) const {
  if (primitive_) return Exactly(p);
  return ValueAt(p, FindClosestPoint(mesh_->bvh(), p, kInfinity, hint_slot));
}

bool ProbedSurface::ProbeWithin(const Vec3& p, double reach, std::int32_t hint_slot,
                                FieldValue* value) const {
  if (primitive_) {
    *value = Exactly(p);
    return !(std::abs(value->phi) > reach);
  }
  const ClosestPoint closest = FindClosestPoint(mesh_->bvh(), p, reach * reach, hint_slot);
  if (closest.slot < 0) return false;
  *value = ValueAt(p, closest);
  return true;
}

FieldValue ProbedSurface::Probe(const Vec3& p, std::span<const NearFacet> facets,
                                double motion) const {
  if (primitive_ || facets.empty()) return Probe(p);
  return ValueAt(p, FindClosestAmong(mesh_->bvh(), p, facets, motion));
}

FieldValue ProbedSurface::Exactly(const Vec3& p) const {
  const auto [phi, gradient] = primitive_.At(p);
  return {phi, gradient, 0, -1};
}

FieldValue ProbedSurface::ValueAt(const Vec3& p, const ClosestPoint& closest) const {
  const SignedDistance at = solid_->SignAt(p, closest);
  if (closed_) return {at.distance, at.gradient, 0, at.slot};
  const double side = at.distance < 0 ? -1 : 1;
  return {side * at.distance, side * at.gradient,
          OnBoundary(at.feature) ? 0 : static_cast<int>(side), at.slot};
}

}  // namespace contact_toolkit
