// What is known of a surface in balls about lattice points, computed when first asked for: which of
// numbered regions it is there, and how far that goes.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "math/vec.h"
#include "shapes/mesh.h"
#include "web/area/lattice_memo.h"

namespace contact_toolkit {

struct KnownRegion {
  std::int32_t index = -1;  // -1: none is known
  double clear = 0;         // [m] how far it goes from where it was asked about
  double doubt = 0;  // [m] at the same point, what is known from another lattice point may be
                     // less by this, and a kUncertain of `clear`
  static constexpr double kUncertain = 0.01;
  double at_most = 0;  // [m] it goes no farther than this
};

class RegionMemo {
 public:
  // Larger indices are not kept.
  static constexpr std::int32_t kMostRegions = (1 << 15) - 1;

  // `finest` [m]: spacing of the finest lattice.
  RegionMemo(double finest, const CollisionMesh& mesh)
      : middle_(0.5 * (mesh.lower() + mesh.upper())), memo_(finest, LargestHalf(mesh)) {}

  // About `center`, for a ball of this radius. `measure(p, spacing)` gives the region at a lattice
  // point: an index and how far it goes, whatever stands in `doubt`.
  template <typename Measure>
  KnownRegion About(const Vec3& center, double radius, const Measure& measure) const {
    LatticeMemo::Point point;
    if (!memo_.Next(center - middle_, 0.5 * radius, &point)) return {};
    const double spacing = memo_.spacing(point.level);
    const std::uint32_t value = memo_.ValueAt(point, [&]() -> std::uint32_t {
      const KnownRegion region = measure(middle_ + point.offset, spacing);
      if (region.index < 0 || region.index >= kMostRegions || !(region.clear > 0)) return 0;
      return static_cast<std::uint32_t>(region.index) << kHalfBits |
             std::bit_cast<std::uint32_t>(static_cast<float>((1 - kRounding) * region.clear)) >> 16;
    });
    const std::uint32_t clear = value & ((1u << kHalfBits) - 1);
    if (clear == 0) return {};
    const double away = std::sqrt(point.squared_distance);
    return {static_cast<std::int32_t>(value >> kHalfBits), std::bit_cast<float>(clear << 16) - away,
            2 * std::sqrt(0.75) * spacing,
            kMostRounding * std::bit_cast<float>(clear << 16) + away};
  }

 private:
  // A value is an index in 15 bits and a positive float without sign and the last 16 bits.
  static constexpr int kHalfBits = 15;
  static constexpr double kRounding = 0.008;      // [-] more than the missing bits are worth
  static constexpr double kMostRounding = 1.017;  // [-] what stood there over what is kept

  static double LargestHalf(const CollisionMesh& mesh) {
    const Vec3 half = 0.5 * (mesh.upper() - mesh.lower());
    return std::max({half.x, half.y, half.z});
  }

  Vec3 middle_;
  LatticeMemo memo_;
};

}  // namespace contact_toolkit
