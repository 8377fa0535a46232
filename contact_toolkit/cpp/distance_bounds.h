// Lower bounds of a probed surface's distance, for culling what cannot touch it. The distance is
// known on lattices of doubling spacing and changes no faster than the point moves.
//
// The table remembers values of a pure function and may forget any of them, so what it holds
// changes the time taken and nothing else. One 64-bit word holds the lattice point and its value,
// so threads share it without locks.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "probed_surface.h"
#include "vec.h"

namespace contact_toolkit {

class DistanceBounds {
 public:
  // `finest` [m]: spacing of the finest lattice.
  DistanceBounds(std::shared_ptr<const ProbedSurface> surface, double finest);

  // Whether the distance certainly exceeds `reach` throughout the ball.
  bool Beyond(const Vec3& center, double radius, double reach) const;

  // [m] The distance of a point is no less; often by far.
  double LowerBound(const Vec3& p) const;

 private:
  // A lattice point is named by 14 bits an axis and 4 bits of level: 46 bits, which are scrambled
  // without loss. 12 of them choose a set of eight words, the other 34 stand in a word of it beside
  // the value, a float without its last two bits.
  static constexpr int kAxisBits = 14, kLevelBits = 4, kTagBits = 34;
  static constexpr int kKeyBits = 3 * kAxisBits + kLevelBits, kValueBits = 64 - kTagBits;
  static constexpr int kLevels = 1 << kLevelBits;
  static constexpr int kWays = 8;
  static constexpr std::size_t kSets = std::size_t{1} << (kKeyBits - kTagBits);
  struct alignas(8 * kWays) Set {  // a cache line
    std::array<std::atomic<std::uint64_t>, kWays> words;
  };

  // What is known at the lattice point next to a point given from the middle, on the coarsest
  // lattice whose spacing is no more than the radius.
  struct Known {
    double distance, squared_offset;
  };
  Known Near(const Vec3& local, double radius) const;
  double SquaredGap(const Vec3& local) const;
  float ValueAt(int level, const std::array<std::int32_t, 3>& index) const;
  float Remember(std::uint64_t key, int level, const std::array<std::int32_t, 3>& index) const;

  std::shared_ptr<const ProbedSurface> surface_;
  Vec3 middle_, half_;
  double far_;  // [m] outside the box by more than this, no lattice is consulted
  std::array<double, kLevels> spacing_, inverse_spacing_;
  int first_level_ = 0;  // finer ones have too many points for their names
  std::unique_ptr<Set[]> sets_;
};

}  // namespace contact_toolkit
