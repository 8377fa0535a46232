#include "web/area/distance_bounds.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace contact_toolkit {
namespace {

// [-] Of a value is given away to round it down, more than its missing bits are worth.
constexpr double kRounding = 1e-6;

// A float keeps all but its last two bits.
constexpr int kCutOff = 32 - LatticeMemo::kValueBits;

double LargestHalf(const CollisionMesh& mesh) {
  const Vec3 half = 0.5 * (mesh.upper() - mesh.lower());
  return std::max({half.x, half.y, half.z});
}

}  // namespace

DistanceBounds::DistanceBounds(std::shared_ptr<const ProbedSurface> surface, double finest)
    : surface_(std::move(surface)), memo_(finest, LargestHalf(surface_->mesh())) {
  const CollisionMesh& mesh = surface_->mesh();
  middle_ = 0.5 * (mesh.lower() + mesh.upper());
  half_ = 0.5 * (mesh.upper() - mesh.lower());
  far_ = 0.4 * LargestHalf(mesh);
}

bool DistanceBounds::Beyond(const Vec3& center, double radius, double reach) const {
  if (surface_->primitive()) return surface_->Probe(center).phi > reach + radius;
  const Vec3 local = center - middle_;
  const double squared = SquaredGap(local);
  const double within = reach + radius;
  if (squared > within * within) return true;
  if (squared > far_ * far_) return false;
  const Known known = Near(local, radius);
  const double margin = known.distance - within;
  return margin > 0 && margin * margin > known.squared_offset;
}

double DistanceBounds::LowerBound(const Vec3& p) const {
  if (surface_->primitive()) return surface_->Probe(p).phi;
  constexpr double kRoundedUp = 1 + 1e-12;
  const Vec3 local = p - middle_;
  const double squared = SquaredGap(local);
  if (squared > far_ * far_) return std::sqrt(squared) / kRoundedUp;
  const Known known = Near(local, 0);
  return known.distance - std::sqrt(known.squared_offset) * kRoundedUp;
}

// Of a point from the surface's box.
double DistanceBounds::SquaredGap(const Vec3& local) const {
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    const double gap = std::max(std::abs(local[i]) - half_[i], 0.0);
    squared += gap * gap;
  }
  return squared;
}

// The distance at the lattice point, rounded down.
DistanceBounds::Known DistanceBounds::Near(const Vec3& local, double radius) const {
  LatticeMemo::Point point;
  if (!memo_.Next(local, radius, &point)) return {-std::numeric_limits<double>::infinity(), 0};
  const std::uint32_t kept = memo_.ValueAt(point, [&] {
    const double phi = surface_->Probe(middle_ + point.offset).phi;
    const auto rounded = static_cast<float>(phi - kRounding * std::abs(phi));
    return std::bit_cast<std::uint32_t>(rounded) >> kCutOff;
  });
  return {std::bit_cast<float>(kept << kCutOff), point.squared_distance};
}

}  // namespace contact_toolkit
