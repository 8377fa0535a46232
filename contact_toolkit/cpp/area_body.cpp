#include "area_body.h"

#include <utility>

#include "thickness.h"

namespace contact_toolkit {

AreaBody::AreaBody(std::shared_ptr<const CollisionMesh> mesh)
    : mesh_(std::move(mesh)), surface_(std::make_shared<const ProbedSurface>(mesh_)) {}

double AreaBody::thickness() const {
  const std::lock_guard lock(mutex_);
  if (thickness_ < 0) thickness_ = FindThickness(*mesh_);
  return thickness_;
}

std::shared_ptr<const AreaNodes> AreaBody::nodes(double spacing) const {
  const std::lock_guard lock(mutex_);
  auto& kept = nodes_[spacing];
  if (!kept) kept = std::make_shared<const AreaNodes>(mesh_, spacing);
  return kept;
}

std::shared_ptr<const DistanceBounds> AreaBody::bounds(double finest) const {
  const std::lock_guard lock(mutex_);
  auto& kept = bounds_[finest];
  if (!kept) kept = std::make_shared<const DistanceBounds>(surface_, finest);
  return kept;
}

std::shared_ptr<const SmoothField> AreaBody::smooth_field(double cell) const {
  const std::lock_guard lock(mutex_);
  auto& kept = smooth_fields_[cell];
  if (!kept) kept = std::make_shared<const SmoothField>(surface_, cell);
  return kept;
}

}  // namespace contact_toolkit
