// Where the distance from a surface is that from one plane: about the middle of its flat sides.
// There a linear deformation is no approximation, and one large triangle does for many small ones.
#pragma once

#include <memory>

#include "math/vec.h"
#include "web/area/flat_sides.h"
#include "web/area/probed_surface.h"
#include "web/area/region_memo.h"

namespace contact_toolkit {

class FlatRegions {
 public:
  // `finest` [m]: spacing of the finest lattice on which regions are known.
  FlatRegions(std::shared_ptr<const ProbedSurface> surface, double finest);

  const FlatSides& flats() const { return flats_; }
  const FlatSides::Side& side(std::int32_t index) const { return flats_.sides[index]; }

  // Of a side: the closest facet is one of it at every point of a ball about `center` that is no
  // farther from its plane than `clear` less the ball's radius.
  KnownRegion About(const Vec3& center, double radius) const;

 private:
  KnownRegion Measure(const Vec3& p) const;

  std::shared_ptr<const ProbedSurface> surface_;
  FlatSides flats_;
  RegionMemo memo_;
};

}  // namespace contact_toolkit
