#include "distance_bounds.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace contact_toolkit {
namespace {

constexpr std::uint64_t kNothing = ~0ull;  // holds a NaN as value: no lattice point has it

// [-] Of a value is given away to round it down, more than its missing bits are worth.
constexpr double kRounding = 1e-6;

}  // namespace

DistanceBounds::DistanceBounds(std::shared_ptr<const ProbedSurface> surface, double finest)
    : surface_(std::move(surface)) {
  const CollisionMesh& mesh = surface_->mesh();
  middle_ = 0.5 * (mesh.lower() + mesh.upper());
  half_ = 0.5 * (mesh.upper() - mesh.lower());
  const double largest = std::max({half_.x, half_.y, half_.z});
  far_ = 0.4 * largest;
  for (int level = 0; level < kLevels; ++level) {
    spacing_[level] = std::ldexp(finest, level);
    inverse_spacing_[level] = 1 / spacing_[level];
  }
  constexpr int kHalfAxis = 1 << (kAxisBits - 1);
  while (first_level_ + 1 < kLevels && spacing_[first_level_] * (kHalfAxis - 2) < 1.5 * largest) {
    ++first_level_;
  }
  sets_ = std::make_unique<Set[]>(kSets);
  for (std::size_t i = 0; i < kSets; ++i) {
    for (auto& word : sets_[i].words) word.store(kNothing, std::memory_order_relaxed);
  }
}

bool DistanceBounds::Beyond(const Vec3& center, double radius, double reach) const {
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

DistanceBounds::Known DistanceBounds::Near(const Vec3& local, double radius) const {
  int level = first_level_;
  while (level + 1 < kLevels && spacing_[level + 1] <= radius) ++level;
  std::array<std::int32_t, 3> index;
  double squared_offset = 0;
  for (int i = 0; i < 3; ++i) {
    const double x = local[i] * inverse_spacing_[level];
    constexpr double kHalfAxis = 1 << (kAxisBits - 1);
    if (!(std::abs(x) < kHalfAxis - 1)) return {-std::numeric_limits<double>::infinity(), 0};
    index[i] = static_cast<std::int32_t>(x + kHalfAxis + 0.5);  // counted from the lattice's corner
    const double beside = local[i] - (index[i] - kHalfAxis) * spacing_[level];
    squared_offset += beside * beside;
  }
  return {ValueAt(level, index), squared_offset};
}

// The distance at a lattice point, rounded down.
float DistanceBounds::ValueAt(int level, const std::array<std::int32_t, 3>& index) const {
  constexpr std::uint64_t kKeyMask = (1ull << kKeyBits) - 1;
  std::uint64_t key = level;
  for (const std::int32_t i : index) key = key << kAxisBits | i;
  // Odd multiplication and shifted exclusive-or lose nothing modulo a power of two.
  key = key * 0x9e3779b97f4a7c15ull & kKeyMask;
  key ^= key >> (kKeyBits / 2);
  key = key * 0xbf58476d1ce4e5b9ull & kKeyMask;
  const std::uint64_t tag = key & ((1ull << kTagBits) - 1);
  for (const auto& word : sets_[key >> kTagBits].words) {
    const std::uint64_t found = word.load(std::memory_order_relaxed);
    if (found >> kValueBits == tag && found != kNothing) {
      return std::bit_cast<float>(static_cast<std::uint32_t>(found << (32 - kValueBits)));
    }
  }
  return Remember(key, level, index);
}

float DistanceBounds::Remember(std::uint64_t key, int level,
                               const std::array<std::int32_t, 3>& index) const {
  Vec3 point = middle_;
  for (int i = 0; i < 3; ++i) point[i] += (index[i] - (1 << (kAxisBits - 1))) * spacing_[level];
  const double phi = surface_->Probe(point).phi;
  const auto bits =
      std::bit_cast<std::uint32_t>(static_cast<float>(phi - kRounding * std::abs(phi)));
  const std::uint32_t kept = bits >> (32 - kValueBits);
  // The newest first, the oldest forgotten.
  auto& words = sets_[key >> kTagBits].words;
  for (int way = kWays - 1; way > 0; --way) {
    words[way].store(words[way - 1].load(std::memory_order_relaxed), std::memory_order_relaxed);
  }
  words[0].store(key << kValueBits | kept, std::memory_order_relaxed);
  return std::bit_cast<float>(kept << (32 - kValueBits));
}

}  // namespace contact_toolkit
