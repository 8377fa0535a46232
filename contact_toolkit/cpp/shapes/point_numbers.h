// Numbers of points in the order in which they are first met, exactly coincident ones alike.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "math/vec.h"

namespace contact_toolkit {

// Appends each point that is new to it to `points`, where a point's number is its place; others may
// append too. A table with open addressing: one look at memory for a point, wherever it comes in
// the order.
class PointNumbers {
 public:
  explicit PointNumbers(std::vector<Vec3>* points, std::size_t expected = 0)
      : points_(*points), table_(std::bit_ceil(2 * expected + 16), -1) {}

  std::int32_t Of(const Vec3& p) {
    if (2 * count_ >= table_.size()) Grow();
    std::int32_t* place = Place(p);
    if (*place < 0) {
      *place = static_cast<std::int32_t>(points_.size());
      points_.push_back(p);
      ++count_;
    }
    return *place;
  }

 private:
  static std::size_t Hash(const Vec3& p) {
    std::size_t hash = 0;
    for (int i = 0; i < 3; ++i) {
      const double value = p[i] + 0.0;  // -0.0 and 0.0 coincide
      std::uint64_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      hash = (hash ^ bits) * 0x9e3779b97f4a7c15ull;
      hash ^= hash >> 32;
    }
    return hash;
  }

  // Of the point in the table, or where it belongs.
  std::int32_t* Place(const Vec3& p) {
    const std::size_t mask = table_.size() - 1;
    std::size_t at = Hash(p) & mask;
    while (table_[at] >= 0 && !(points_[table_[at]] == p)) at = (at + 1) & mask;
    return &table_[at];
  }

  void Grow() {
    std::vector<std::int32_t> old(2 * table_.size(), -1);
    std::swap(old, table_);
    for (const std::int32_t number : old) {
      if (number >= 0) *Place(points_[number]) = number;
    }
  }

  std::vector<Vec3>& points_;
  std::vector<std::int32_t> table_;  // -1: nothing there
  std::size_t count_ = 0;            // of numbers in the table
};

}  // namespace contact_toolkit
