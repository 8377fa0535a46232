// What the area web derives from one mesh alone. Shared by all pairs of the geometry, so that a
// hundred parts in a bin do not build it a hundred times; each item is made when first asked for,
// and what is of a spacing goes with the last pair that has it: the other body's size decides that.
#pragma once

#include <array>
#include <memory>
#include <mutex>

#include "base/while_used.h"
#include "shapes/mesh.h"
#include "web/area/area_nodes.h"
#include "web/area/distance_bounds.h"
#include "web/area/flat_regions.h"
#include "web/area/probed_surface.h"
#include "web/area/smooth_field.h"
#include "web/area/wedge_regions.h"

namespace contact_toolkit {

class AreaBody {
 public:
  // `primitive`: what the mesh stands for.
  explicit AreaBody(std::shared_ptr<const Solid> solid, const Primitive& primitive = {});

  // The solid's own: what is doubled counts once, walls within it do not count.
  const CollisionMesh& mesh() const { return *mesh_; }
  const std::shared_ptr<const CollisionMesh>& shared_mesh() const { return mesh_; }
  const std::shared_ptr<const ProbedSurface>& surface() const { return surface_; }

  // [m] See FindThickness.
  double thickness() const;
  // [m] By which what the mesh stands for is larger, at most.
  double overhang() const;
  // [-] The fraction of its surface that is in large flat sides: 1 of a box.
  double flatness() const;
  std::shared_ptr<const AreaNodes> nodes(double spacing, const RoundLattice& round = {}) const;
  std::shared_ptr<const DistanceBounds> bounds(double finest) const;
  std::shared_ptr<const FlatRegions> flats(double finest) const;
  std::shared_ptr<const WedgeRegions> wedges(double finest) const;
  std::shared_ptr<const SmoothField> smooth_field(double cell) const;

 private:
  std::shared_ptr<const CollisionMesh> mesh_;
  std::shared_ptr<const ProbedSurface> surface_;
  mutable std::mutex mutex_;
  mutable double thickness_ = -1, flatness_ = -1, overhang_ = -1;  // not yet found
  mutable WhileUsed<std::array<double, 3>, AreaNodes> nodes_;
  mutable WhileUsed<double, DistanceBounds> bounds_;
  mutable WhileUsed<double, FlatRegions> flats_;
  mutable WhileUsed<double, WedgeRegions> wedges_;
  mutable WhileUsed<double, SmoothField> smooth_fields_;
};

}  // namespace contact_toolkit
