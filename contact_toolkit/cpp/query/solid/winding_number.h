// The generalized winding number of a set of facets about a point: how many times they enclose it.
// An integer off a closed surface; where a surface has holes or cracks it still is near one away
// from them (Jacobson, Kavan and Sorkine-Hornung, "Robust inside-outside segmentation using
// generalized winding numbers", ACM TOG 32(4), 2013).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "math/vec.h"

namespace contact_toolkit {

// A facet's share, its solid angle over the whole sphere's; zero in the facet's own plane (Van
// Oosterom and Strackee, "The solid angle of a plane triangle", 1983).
double WindingOf(const std::array<Vec3, 3>& facet, const Vec3& p);

// Facets far away are taken together, as dipoles (Barill et al., "Fast winding numbers for soups
// and clouds", ACM TOG 37(4), 2018): right to some 1e-2, in logarithmic time. Immutable.
class WindingTree {
 public:
  // Facets wound counter-clockwise seen from outside.
  explicit WindingTree(std::vector<std::array<Vec3, 3>> facets);

  double At(const Vec3& p) const;
  bool Encloses(const Vec3& p) const { return At(p) > 0.5; }

 private:
  struct Node {
    Vec3 center, dipole;  // the mean by area; the sum of the area vectors [m²]
    double radius = 0;    // no corner lies farther from the centre
    std::int32_t first = 0, last = 0;
    std::int32_t right = -1;  // the left child follows its parent; -1: a leaf
  };

  void Build(std::int32_t first, std::int32_t last);

  std::vector<std::array<Vec3, 3>> facets_;
  std::vector<Node> nodes_;
};

}  // namespace contact_toolkit
