// What the area web derives from one mesh alone. Shared by all pairs of the geometry, so that a
// hundred parts in a bin do not build it a hundred times; each item is made when first asked for.
#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "area_nodes.h"
#include "distance_bounds.h"
#include "mesh.h"
#include "probed_surface.h"
#include "smooth_field.h"

namespace contact_toolkit {

class AreaBody {
 public:
  explicit AreaBody(std::shared_ptr<const CollisionMesh> mesh);

  const CollisionMesh& mesh() const { return *mesh_; }
  const std::shared_ptr<const CollisionMesh>& shared_mesh() const { return mesh_; }
  const std::shared_ptr<const ProbedSurface>& surface() const { return surface_; }

  // [m] See FindThickness.
  double thickness() const;
  std::shared_ptr<const AreaNodes> nodes(double spacing) const;
  std::shared_ptr<const DistanceBounds> bounds(double finest) const;
  std::shared_ptr<const SmoothField> smooth_field(double cell) const;

 private:
  std::shared_ptr<const CollisionMesh> mesh_;
  std::shared_ptr<const ProbedSurface> surface_;
  mutable std::mutex mutex_;
  mutable double thickness_ = -1;  // not yet found
  mutable std::map<double, std::shared_ptr<const AreaNodes>> nodes_;
  mutable std::map<double, std::shared_ptr<const DistanceBounds>> bounds_;
  mutable std::map<double, std::shared_ptr<const SmoothField>> smooth_fields_;
};

}  // namespace contact_toolkit
