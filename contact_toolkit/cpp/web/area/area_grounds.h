// What of the probed body lies under triangles of the sampled one, where that is flat: there the
// deformation is linear, or the least of a few that are, and needs no nodes in between.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "math/vec.h"
#include "web/area/area_nodes.h"
#include "web/area/flat_regions.h"
#include "web/area/smooth_field.h"
#include "web/area/wedge_regions.h"

namespace contact_toolkit {

class AreaGrounds {
 public:
  AreaGrounds() = default;
  // `flats` may be null: nothing is flat; `wedges` too: only sides are told; `smooth` with the
  // exact field.
  AreaGrounds(std::shared_ptr<const FlatRegions> flats, std::shared_ptr<const WedgeRegions> wedges,
              std::shared_ptr<const SmoothField> smooth);

  // All of the probed body that a triangle of the sampled one can meet when every point moves by up
  // to `way` [m] from a pose: a flat side or, numbered after those, a wedge; -1: not certain.
  std::int32_t Under(const Pose& X_PS, const Corners& corners, double way) const;
  // A flat side that all triangles of a leaf meet, and each by itself as above. `height` [m]: the
  // least over that.
  std::int32_t SideUnder(const Pose& X_PS, const AreaPatch::Leaf& leaf, double way,
                         double* height) const;
  // Whether Under() is certainly -1 at each of the poses.
  bool IsNeverFlatUnder(const Pose& X_PS, const Corners& corners, double way) const;

  // Whether a ground may be a wedge.
  bool has_wedges() const { return wedges_ && !wedges_->empty(); }
  // The flat sides of a ground.
  std::span<const std::int32_t> SidesOf(const std::int32_t& ground) const;
  const FlatSides::Side& side(std::int32_t index) const { return flats_->side(index); }

 private:
  std::int32_t SideUnder(const Pose& X_PS, const Corners& corners, double way) const;
  std::int32_t WedgeUnder(const Pose& X_PS, const Corners& corners, double way) const;
  bool IsExact(const Vec3& center, double radius, double way) const;

  std::shared_ptr<const FlatRegions> flats_;
  std::shared_ptr<const WedgeRegions> wedges_;
  std::shared_ptr<const SmoothField> smooth_;
  double margin_ = 0;  // [m] by which the field looks beyond a point
};

}  // namespace contact_toolkit
