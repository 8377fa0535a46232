// A table that remembers values of a pure function on lattices of doubling spacing and may forget
// any of them, so what it holds changes the time taken and nothing else. One 64-bit word holds the
// lattice point and its value, so threads share it without locks.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>

#include "math/vec.h"

namespace contact_toolkit {

class LatticeMemo {
 public:
  static constexpr int kValueBits = 30;
  static constexpr std::uint32_t kNoValue = (1u << kValueBits) - 1;  // never to be remembered

  struct Point {
    int level;
    std::array<std::int32_t, 3> index;
    Vec3 offset;              // from the middle
    double squared_distance;  // of what was asked about
  };

  // `finest` [m]: spacing of the finest lattice. `half`: of the region's longest side.
  LatticeMemo(double finest, double half) {
    for (int level = 0; level < kLevels; ++level) {
      spacing_[level] = std::ldexp(finest, level);
      inverse_spacing_[level] = 1 / spacing_[level];
    }
    while (first_level_ + 1 < kLevels && spacing_[first_level_] * (kHalfAxis - 2) < 1.5 * half) {
      ++first_level_;
    }
    sets_ = std::make_unique<Set[]>(kSets);
    for (std::size_t i = 0; i < kSets; ++i) {
      for (auto& word : sets_[i].words) word.store(kNothing, std::memory_order_relaxed);
    }
  }

  double spacing(int level) const { return spacing_[level]; }

  // The lattice point next to one given from the middle, on the coarsest lattice whose spacing is
  // no more than the radius. False where there is none.
  bool Next(const Vec3& local, double radius, Point* point) const {
    int level = first_level_;
    while (level + 1 < kLevels && spacing_[level + 1] <= radius) ++level;
    point->level = level;
    point->squared_distance = 0;
    for (int i = 0; i < 3; ++i) {
      const double x = local[i] * inverse_spacing_[level];
      if (!(std::abs(x) < kHalfAxis - 1)) return false;
      // Counted from the lattice's corner.
      point->index[i] = static_cast<std::int32_t>(x + kHalfAxis + 0.5);
      point->offset[i] = (point->index[i] - kHalfAxis) * spacing_[level];
      const double beside = local[i] - point->offset[i];
      point->squared_distance += beside * beside;
    }
    return true;
  }

  // `make()`: the value there, of which the last 30 bits are kept.
  template <typename Make>
  std::uint32_t ValueAt(const Point& point, const Make& make) const {
    constexpr std::uint64_t kKeyMask = (1ull << kKeyBits) - 1;
    std::uint64_t key = point.level;
    for (const std::int32_t i : point.index) key = key << kAxisBits | i;
    // Odd multiplication and shifted exclusive-or lose nothing modulo a power of two.
    key = key * 0x9e3779b97f4a7c15ull & kKeyMask;
    key ^= key >> (kKeyBits / 2);
    key = key * 0xbf58476d1ce4e5b9ull & kKeyMask;
    const std::uint64_t tag = key & ((1ull << kTagBits) - 1);
    auto& words = sets_[key >> kTagBits].words;
    for (const auto& word : words) {
      const std::uint64_t found = word.load(std::memory_order_relaxed);
      if (found >> kValueBits == tag && found != kNothing) {
        return static_cast<std::uint32_t>(found) & kNoValue;
      }
    }
    const std::uint32_t value = make() & kNoValue;
    // The newest first, the oldest forgotten.
    for (int way = kWays - 1; way > 0; --way) {
      words[way].store(words[way - 1].load(std::memory_order_relaxed), std::memory_order_relaxed);
    }
    words[0].store(tag << kValueBits | value, std::memory_order_relaxed);
    return value;
  }

 private:
  // A lattice point is named by 14 bits an axis and 4 bits of level: 46 bits, which are scrambled
  // without loss. 12 of them choose a set of eight words, the other 34 stand in a word of it beside
  // the value.
  static constexpr int kAxisBits = 14, kLevelBits = 4, kTagBits = 64 - kValueBits;
  static constexpr int kKeyBits = 3 * kAxisBits + kLevelBits;
  static constexpr int kLevels = 1 << kLevelBits;
  static constexpr int kHalfAxis = 1 << (kAxisBits - 1);
  static constexpr int kWays = 8;
  static constexpr std::size_t kSets = std::size_t{1} << (kKeyBits - kTagBits);
  static constexpr std::uint64_t kNothing = ~0ull;  // its value is kNoValue
  struct alignas(8 * kWays) Set {                   // a cache line
    std::array<std::atomic<std::uint64_t>, kWays> words;
  };

  std::array<double, kLevels> spacing_, inverse_spacing_;
  int first_level_ = 0;  // finer ones have too many points for their names
  std::unique_ptr<Set[]> sets_;
};

}  // namespace contact_toolkit
