#include "probed_surface.h"

#include <limits>
#include <utility>

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

ProbedSurface::ProbedSurface(std::shared_ptr<const CollisionMesh> mesh)
    : mesh_(std::move(mesh)), closed_(mesh_->defects().closed()) {
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
      // Also an inner edge that joins two boundary vertices: a side not told is only noticed later.
      const auto [a, b] = mesh_->edges()[feature.index];
      return boundary_vertex_[a] && boundary_vertex_[b];
    }
    default:
      return false;
  }
}

FieldValue ProbedSurface::Probe(const Vec3& p, std::int32_t hint_slot) const {
  return ValueAt(p, FindClosestPoint(mesh_->bvh(), p, kInfinity, hint_slot));
}

bool ProbedSurface::ProbeWithin(const Vec3& p, double reach, std::int32_t hint_slot,
                                FieldValue* value) const {
  const ClosestPoint closest = FindClosestPoint(mesh_->bvh(), p, reach * reach, hint_slot);
  if (closest.slot < 0) return false;
  *value = ValueAt(p, closest);
  return true;
}

FieldValue ProbedSurface::Probe(const Vec3& p, std::span<const NearFacet> facets,
                                double motion) const {
  if (facets.empty()) return Probe(p);
  return ValueAt(p, FindClosestAmong(mesh_->bvh(), p, facets, motion));
}

FieldValue ProbedSurface::ValueAt(const Vec3& p, const ClosestPoint& closest) const {
  const SignedDistance at = SignOf(*mesh_, p, closest);
  if (closed_) return {at.distance, at.gradient, 0, at.slot};
  const double side = at.distance < 0 ? -1 : 1;
  return {side * at.distance, side * at.gradient,
          OnBoundary(at.feature) ? 0 : static_cast<int>(side), at.slot};
}

}  // namespace contact_toolkit
