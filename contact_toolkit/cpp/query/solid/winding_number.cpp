#include "query/solid/winding_number.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace contact_toolkit {
namespace {

constexpr double kInPlane = 1e-14;       // [-] of the corners' distances: no side
constexpr double kFarAway = 3;           // radii: nearer, the parts are looked at
constexpr std::int32_t kLeafFacets = 8;  // as many as cost about as much as a node

Vec3 Middle(const std::array<Vec3, 3>& t) { return (t[0] + t[1] + t[2]) / 3; }
Vec3 AreaVector(const std::array<Vec3, 3>& t) { return 0.5 * Cross(t[1] - t[0], t[2] - t[0]); }

}  // namespace

double WindingOf(const std::array<Vec3, 3>& facet, const Vec3& p) {
  const Vec3 a = facet[0] - p, b = facet[1] - p, c = facet[2] - p;
  const double la = Norm(a), lb = Norm(b), lc = Norm(c);
  const double volume = Dot(a, Cross(b, c)), scale = la * lb * lc;
  if (!(std::abs(volume) > kInPlane * scale)) return 0;
  const double cosine = scale + Dot(a, b) * lc + Dot(b, c) * la + Dot(c, a) * lb;
  return std::atan2(volume, cosine) / (2 * std::numbers::pi);
}

WindingTree::WindingTree(std::vector<std::array<Vec3, 3>> facets) : facets_(std::move(facets)) {
  if (!facets_.empty()) Build(0, static_cast<std::int32_t>(facets_.size()));
}

void WindingTree::Build(std::int32_t first, std::int32_t last) {
  const auto index = nodes_.size();
  Node node;
  node.first = first;
  node.last = last;
  double area = 0;
  Vec3 lower = Middle(facets_[first]), upper = lower, sum;
  for (std::int32_t i = first; i < last; ++i) {
    const Vec3 middle = Middle(facets_[i]), vector = AreaVector(facets_[i]);
    const double size = Norm(vector);
    node.dipole += vector;
    sum += size * middle;
    area += size;
    for (int k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], middle[k]);
      upper[k] = std::max(upper[k], middle[k]);
    }
  }
  node.center = area > 0 ? sum / area : 0.5 * (lower + upper);
  for (std::int32_t i = first; i < last; ++i) {
    for (const Vec3& corner : facets_[i]) {
      node.radius = std::max(node.radius, Norm(corner - node.center));
    }
  }
  nodes_.push_back(node);
  if (last - first <= kLeafFacets) return;
  const Vec3 extent = upper - lower;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::int32_t middle = first + (last - first) / 2;
  std::nth_element(
      facets_.begin() + first, facets_.begin() + middle, facets_.begin() + last,
      [axis](const auto& a, const auto& b) { return Middle(a)[axis] < Middle(b)[axis]; });
  Build(first, middle);
  nodes_[index].right = static_cast<std::int32_t>(nodes_.size());
  Build(middle, last);
}

double WindingTree::At(const Vec3& p) const {
  if (nodes_.empty()) return 0;
  double sum = 0;
  std::int32_t stack[64];
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::int32_t index = stack[--size];
    const Node& node = nodes_[index];
    const Vec3 way = node.center - p;
    const double squared = SquaredNorm(way);
    if (squared > kFarAway * kFarAway * node.radius * node.radius) {
      sum += Dot(node.dipole, way) / (4 * std::numbers::pi * squared * std::sqrt(squared));
    } else if (node.right < 0) {
      for (std::int32_t i = node.first; i < node.last; ++i) sum += WindingOf(facets_[i], p);
    } else {
      stack[size++] = index + 1;
      stack[size++] = node.right;
    }
  }
  return sum;
}

}  // namespace contact_toolkit
