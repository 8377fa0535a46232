#include "web/area/flat_regions.h"

#include <cmath>
#include <utility>

#include "query/point/point_distance.h"

namespace contact_toolkit {
namespace {

constexpr double kFar = 1e15;  // [m] where a side has no others

// Whether a cylinder's wall is closer than its ends: that costs less than what it saves.
bool OnWall(const Primitive& primitive, const Vec3& p) {
  if (primitive.kind != Primitive::Kind::kCylinder) return false;
  const double over_end = std::abs(p.z) - 0.5 * primitive.size.y, at = over_end + primitive.size.x;
  return at < 0 || p.x * p.x + p.y * p.y > at * at;
}

}  // namespace

FlatRegions::FlatRegions(std::shared_ptr<const ProbedSurface> surface, double finest)
    : surface_(std::move(surface)),
      flats_(FindFlatSides(surface_->mesh())),
      memo_(finest, surface_->mesh()) {}

KnownRegion FlatRegions::About(const Vec3& center, double radius) const {
  return memo_.About(center, radius, [&](const Vec3& p, double) { return Measure(p); });
}

KnownRegion FlatRegions::Measure(const Vec3& p) const {
  if (OnWall(surface_->primitive(), p)) return {};
  const Bvh& bvh = surface_->mesh().bvh();
  const ClosestPoint closest = FindClosestPoint(bvh, p);
  const std::int32_t side = flats_.of_facet[bvh.slot_facet[closest.slot]];
  // The wall of a cylinder is round, whatever its mesh is.
  const bool cylinder = surface_->primitive().kind == Primitive::Kind::kCylinder;
  if (cylinder && std::abs(flats_.sides[side].normal.z) < 0.5) return {};
  const double others = FindDistanceToOthers(bvh, p, flats_.of_facet, {&side, 1}, kFar);
  if (!(others > std::sqrt(closest.squared_distance))) return {};
  return {side, others};
}

}  // namespace contact_toolkit
