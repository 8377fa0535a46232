// A tree of bounding spheres, eight children wide, over spheres that are given in spatial order:
// parent i of a level bounds its children 8 i to 8 i + 7.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.h"

namespace contact_toolkit {

struct Sphere {
  Vec3 center;
  double radius = 0;
};

// Around points, of which there must be some; about their bounding box's centre.
inline Sphere SphereAround(const Vec3* points, std::size_t count) {
  Vec3 lower = points[0], upper = points[0];
  for (std::size_t i = 1; i < count; ++i) {
    for (int k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], points[i][k]);
      upper[k] = std::max(upper[k], points[i][k]);
    }
  }
  Sphere sphere{0.5 * (lower + upper), 0};
  for (std::size_t i = 0; i < count; ++i) {
    sphere.radius = std::max(sphere.radius, Norm(points[i] - sphere.center));
  }
  sphere.radius *= 1 + 1e-12;  // rounding
  return sphere;
}

class SphereTree {
 public:
  SphereTree() = default;
  explicit SphereTree(std::vector<Sphere> leaves) {
    levels_.push_back(std::move(leaves));
    while (levels_.back().size() > 1) levels_.push_back(Parents(levels_.back()));
  }

  // Calls visit(leaf) in order for the leaves that enter(sphere) admits, as it does their
  // ancestors.
  template <typename Enter, typename Visit>
  void ForEach(const Enter& enter, const Visit& visit) const {
    if (levels_.empty() || levels_.back().empty()) return;
    Descend(static_cast<int>(levels_.size()) - 1, 0, enter, visit);
  }

  // Around all of them; there must be some.
  const Sphere& root() const { return levels_.back()[0]; }

 private:
  static constexpr std::size_t kWidth = 8;

  static std::vector<Sphere> Parents(const std::vector<Sphere>& children) {
    std::vector<Sphere> parents;
    for (std::size_t first = 0; first < children.size(); first += kWidth) {
      const std::size_t last = std::min(children.size(), first + kWidth);
      Vec3 sum;
      for (std::size_t i = first; i < last; ++i) sum += children[i].center;
      Sphere parent{sum / static_cast<double>(last - first), 0};
      for (std::size_t i = first; i < last; ++i) {
        parent.radius =
            std::max(parent.radius, Norm(children[i].center - parent.center) + children[i].radius);
      }
      parent.radius *= 1 + 1e-12;  // rounding
      parents.push_back(parent);
    }
    return parents;
  }

  template <typename Enter, typename Visit>
  void Descend(int level, std::size_t index, const Enter& enter, const Visit& visit) const {
    if (!enter(levels_[level][index])) return;
    if (level == 0) {
      visit(static_cast<std::int32_t>(index));
      return;
    }
    const std::size_t last = std::min(levels_[level - 1].size(), kWidth * (index + 1));
    for (std::size_t i = kWidth * index; i < last; ++i) Descend(level - 1, i, enter, visit);
  }

  std::vector<std::vector<Sphere>> levels_;  // leaves first
};

}  // namespace contact_toolkit
