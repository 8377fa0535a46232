#include "web/area/area_body.h"

#include <algorithm>
#include <array>
#include <utility>

#include "web/area/thickness.h"

namespace contact_toolkit {

AreaBody::AreaBody(std::shared_ptr<const Solid> solid, const Primitive& primitive)
    : mesh_(solid->mesh()),
      surface_(std::make_shared<const ProbedSurface>(std::move(solid), primitive)) {}

double AreaBody::thickness() const {
  const std::lock_guard lock(mutex_);
  if (thickness_ < 0) thickness_ = FindThickness(surface_->solid());
  return thickness_;
}

double AreaBody::overhang() const {
  const std::lock_guard lock(mutex_);
  if (overhang_ >= 0) return overhang_;
  overhang_ = 0;
  if (!(surface_->primitive().roundness() > 0)) return overhang_;
  for (const auto& [a, b, c] : mesh_->faces()) {
    const std::array<Vec3, 3> corners{mesh_->vertices()[a], mesh_->vertices()[b],
                                      mesh_->vertices()[c]};
    overhang_ = std::max(overhang_, -surface_->primitive().LeastOver(corners, CenterOf(corners)));
  }
  return overhang_;
}

double AreaBody::flatness() const {
  constexpr double kLarge = 0.02;  // [-] of the whole surface
  const std::lock_guard lock(mutex_);
  if (flatness_ >= 0) return flatness_;
  double area = 0, flat = 0;
  const FlatSides flats = FindFlatSides(*mesh_);
  for (const FlatSides::Side& side : flats.sides) area += side.area;
  for (const FlatSides::Side& side : flats.sides) {
    if (side.area >= kLarge * area) flat += side.area;
  }
  return flatness_ = area > 0 ? flat / area : 0;
}

std::shared_ptr<const AreaNodes> AreaBody::nodes(double spacing, const RoundLattice& round) const {
  const std::lock_guard lock(mutex_);
  return nodes_.Get({spacing, round.across, round.along}, mesh_, spacing, round);
}

std::shared_ptr<const DistanceBounds> AreaBody::bounds(double finest) const {
  const std::lock_guard lock(mutex_);
  return bounds_.Get(finest, surface_, finest);
}

std::shared_ptr<const FlatRegions> AreaBody::flats(double finest) const {
  const std::lock_guard lock(mutex_);
  return flats_.Get(finest, surface_, finest);
}

std::shared_ptr<const WedgeRegions> AreaBody::wedges(double finest) const {
  auto flats = this->flats(finest);
  const std::lock_guard lock(mutex_);
  return wedges_.Get(finest, surface_, std::move(flats), finest);
}

std::shared_ptr<const SmoothField> AreaBody::smooth_field(double cell) const {
  const std::lock_guard lock(mutex_);
  return smooth_fields_.Get(cell, surface_, cell);
}

}  // namespace contact_toolkit
