#include "web/area/area_grounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

AreaGrounds::AreaGrounds(std::shared_ptr<const FlatRegions> flats,
                         std::shared_ptr<const WedgeRegions> wedges,
                         std::shared_ptr<const SmoothField> smooth)
    : flats_(std::move(flats)),
      wedges_(std::move(wedges)),
      smooth_(std::move(smooth)),
      margin_(smooth_ ? 2 * smooth_->support() : 0) {}

std::int32_t AreaGrounds::SideUnder(const Pose& X_PS, const Corners& corners, double way) const {
  if (!flats_) return -1;
  const double radius = RadiusOf(corners);
  auto [side, clear, doubt, at_most] = flats_->About(X_PS * CenterOf(corners), radius);
  if (way > 0) clear -= KnownRegion::kUncertain * clear + doubt + way;
  if (!(clear > radius)) return -1;
  const FlatSides::Side& plane = flats_->side(side);
  double most = way;
  for (const Vec3& corner : corners) {
    most = std::max(most, std::abs(Dot(plane.normal, X_PS * corner) - plane.offset) + way);
  }
  if (clear > radius + margin_ + most) return side;
  return clear > radius + most && smooth_ && IsExact(X_PS * CenterOf(corners), radius, way) ? side
                                                                                            : -1;
}

std::int32_t AreaGrounds::Under(const Pose& X_PS, const Corners& corners, double way) const {
  const std::int32_t side = SideUnder(X_PS, corners, way);
  return side >= 0 || !wedges_ ? side : WedgeUnder(X_PS, corners, way);
}

std::int32_t AreaGrounds::WedgeUnder(const Pose& X_PS, const Corners& corners, double way) const {
  const double radius = RadiusOf(corners);
  auto [index, clear, doubt, at_most] = wedges_->About(X_PS * CenterOf(corners), radius);
  if (way > 0) clear -= KnownRegion::kUncertain * clear + doubt + way;
  if (!(clear > radius)) return -1;
  // Inside the wedge no point is deeper than under the plane that the triangle is least under.
  const Wedge& wedge = wedges_->wedge(index);
  double deepest = kInfinity;
  for (int j = 0; j < wedge.count; ++j) {
    const FlatSides::Side& plane = flats_->side(wedge.side[j]);
    double least = kInfinity;
    for (const Vec3& corner : corners) {
      least = std::min(least, Dot(plane.normal, X_PS * corner) - plane.offset);
    }
    deepest = std::min(deepest, std::max(0.0, way - least));
  }
  if (!(clear > radius + deepest)) return -1;
  return static_cast<std::int32_t>(flats_->flats().sides.size()) + index;
}

bool AreaGrounds::IsNeverFlatUnder(const Pose& X_PS, const Corners& corners, double way) const {
  if (!flats_) return true;
  if (has_wedges()) return false;
  const double radius = RadiusOf(corners);
  const Vec3 center = X_PS * CenterOf(corners);
  const KnownRegion region = flats_->About(center, radius);
  if (region.index < 0) return false;
  // How far a side goes changes no faster than the point moves, and where another is closest, it
  // goes no farther than to this one.
  const double most = region.at_most + way - radius;
  return most <= 0 || (most <= margin_ && !(smooth_ && smooth_->MayBeExact(center, radius, way)));
}

std::span<const std::int32_t> AreaGrounds::SidesOf(const std::int32_t& ground) const {
  const auto num_sides = static_cast<std::int32_t>(flats_->flats().sides.size());
  if (ground < num_sides) return {&ground, 1};
  const Wedge& wedge = wedges_->wedge(ground - num_sides);
  return {wedge.side.data(), static_cast<std::size_t>(wedge.count)};
}

// Whether the smooth field is the exact distance throughout the ball, wherever it moves.
bool AreaGrounds::IsExact(const Vec3& center, double radius, double way) const {
  double doubt;
  return smooth_->IsExact(center, radius, &doubt) &&
         (!(way > 0) || smooth_->IsExact(center, radius + way + doubt, &doubt));
}

std::int32_t AreaGrounds::SideUnder(const Pose& X_PS, const AreaPatch::Leaf& leaf, double way,
                                    double* height) const {
  if (!flats_) return -1;
  const auto& [center_S, radius] = leaf.around;
  const Vec3 center = X_PS * center_S;
  auto [side, clear, doubt, at_most] = flats_->About(center, leaf.largest);
  clear -= KnownRegion::kUncertain * clear + doubt + radius + way;
  const double needed = leaf.largest + margin_;
  if (!(clear > needed)) return -1;
  const FlatSides::Side& plane = flats_->side(side);
  const double over = Dot(plane.normal, center) - plane.offset;
  *height = over - radius;
  return clear > needed + std::abs(over) + radius + way ? side : -1;
}

}  // namespace contact_toolkit
