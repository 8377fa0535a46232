#include "area_nodes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "point_distance.h"
#include "point_numbers.h"
#include "sharp_edges.h"
#include "tolerances.h"

namespace contact_toolkit {
namespace {

constexpr double kFinest = 0.25;      // spacing on sharp edges, as a share of the spacing elsewhere
constexpr double kGradedOver = 2;     // spacings over which it grows back
constexpr int kPatchTriangles = 400;  // aimed at
constexpr double kPatchSpacings = 16;   // the longest edge of a patch's roots
constexpr double kMostPatches = 50000;  // about: a plate of sheet metal under a pea has large ones
constexpr int kLeafTriangles = 8;

double AreaOf(const std::array<Vec3, 3>& t) { return 0.5 * Norm(Cross(t[1] - t[0], t[2] - t[0])); }

}  // namespace

AreaNodes::AreaNodes(std::shared_ptr<const CollisionMesh> mesh, double spacing)
    : mesh_(std::move(mesh)), spacing_(spacing) {
  BuildSharpEdges();
  BuildPatches();
}

void AreaNodes::BuildSharpEdges() {
  std::vector<CollisionMesh::Triple> segments;
  for (const std::int32_t edge : FindSharpEdges(*mesh_)) {
    const auto [a, b] = mesh_->edges()[edge];
    segments.push_back({a, b, b});
  }
  if (!segments.empty()) {
    sharp_edges_ = std::make_unique<Bvh>(BuildBvh(mesh_->vertices(), segments));
  }
}

double AreaNodes::SpacingAt(const Vec3& p) const {
  if (!sharp_edges_) return spacing_;
  const double reach = kGradedOver * spacing_;
  const ClosestPoint closest = FindClosestPoint(*sharp_edges_, p, reach * reach);
  if (closest.slot < 0) return spacing_;
  const double share = std::sqrt(closest.squared_distance) / reach;
  return spacing_ * (kFinest + (1 - kFinest) * share);
}

bool AreaNodes::Splits(const Vec3& a, const Vec3& b) const {
  const double squared = SquaredNorm(b - a);
  if (squared > spacing_ * spacing_) return true;
  if (squared <= kFinest * kFinest * spacing_ * spacing_) return false;
  const double spacing = SpacingAt(0.5 * (a + b));
  return squared > spacing * spacing;
}

// Calls emit(triangle) for the parts that need no further cut or that stop(triangle) accepts.
template <typename Stop, typename Emit>
void AreaNodes::Cut(const Corners& t, const Stop& stop, const Emit& emit) const {
  if (stop(t)) return emit(t);
  bool split[3];
  int count = 0, first = -1;
  for (int k = 0; k < 3; ++k) {
    split[k] = Splits(t[k], t[(k + 1) % 3]);
    if (split[k]) ++count, first = k;
  }
  if (count == 0) return emit(t);
  const auto middle = [&](int k) { return 0.5 * (t[k % 3] + t[(k + 1) % 3]); };
  if (count == 3) {
    const Vec3 m[3] = {middle(0), middle(1), middle(2)};
    Cut({t[0], m[0], m[2]}, stop, emit);
    Cut({m[0], t[1], m[1]}, stop, emit);
    Cut({m[2], m[1], t[2]}, stop, emit);
    Cut({m[0], m[1], m[2]}, stop, emit);
  } else if (count == 1) {
    const Vec3 &a = t[first], &b = t[(first + 1) % 3], &c = t[(first + 2) % 3], m = middle(first);
    Cut({a, m, c}, stop, emit);
    Cut({m, b, c}, stop, emit);
  } else {
    // Turned so that the edge from b to c stays whole; the quadrilateral by its shorter diagonal.
    int k = 0;
    while (split[(k + 1) % 3]) ++k;
    const Vec3 &a = t[k], &b = t[(k + 1) % 3], &c = t[(k + 2) % 3];
    const Vec3 ab = middle(k), ca = middle(k + 2);
    Cut({a, ab, ca}, stop, emit);
    if (SquaredNorm(c - ab) < SquaredNorm(b - ca)) {
      Cut({ab, b, c}, stop, emit);
      Cut({ab, c, ca}, stop, emit);
    } else {
      Cut({ab, b, ca}, stop, emit);
      Cut({b, c, ca}, stop, emit);
    }
  }
}

void AreaNodes::BuildPatches() {
  const double longest =
      std::max(kPatchSpacings * spacing_, 2 * std::sqrt(mesh_->area() / kMostPatches));
  const auto small = [&](const Corners& t) {
    return std::max({SquaredNorm(t[1] - t[0]), SquaredNorm(t[2] - t[1]),
                     SquaredNorm(t[0] - t[2])}) <= longest * longest;
  };
  double triangles = 0;
  Vec3 corner;
  std::vector<Sphere> spheres;
  const auto close = [&] {
    const std::size_t first = first_root_.back();
    if (first == roots_.size()) return;
    spheres.push_back(SphereAround(roots_[first].data(), 3 * (roots_.size() - first)));
    first_root_.push_back(static_cast<std::int32_t>(roots_.size()));
    triangles = 0;
  };
  const std::vector<std::int32_t> sides = FindSides(*mesh_);
  first_root_.push_back(0);
  for (const std::int32_t facet : mesh_->bvh().slot_facet) {
    const auto& f = mesh_->faces()[facet];
    const Corners whole{mesh_->vertices()[f[0]], mesh_->vertices()[f[1]], mesh_->vertices()[f[2]]};
    if (!(AreaOf(whole) > 0)) continue;
    Cut(whole, small, [&](const Corners& t) {
      const double expected = 1 + 4 * AreaOf(t) / (spacing_ * spacing_);
      const bool far = triangles > 0 && Norm(t[0] - corner) > 2 * longest;
      if (triangles + expected > kPatchTriangles || far) close();
      if (triangles == 0) corner = t[0];
      roots_.push_back(t);
      side_of_root_.push_back(sides[facet]);
      triangles += expected;
    });
  }
  close();
  tree_ = SphereTree(std::move(spheres));
  patches_ = std::vector<FirstTouch<AreaPatch>>(first_root_.size() - 1);
}

const AreaPatch& AreaNodes::patch(std::int32_t index) const {
  return patches_[index].Get([&] { return MakePatch(index).release(); });
}

std::unique_ptr<AreaPatch> AreaNodes::MakePatch(std::int32_t index) const {
  auto patch = std::make_unique<AreaPatch>();
  std::map<std::int32_t, PointNumbers> numbers_of_side;
  const auto whole = [](const Corners&) { return false; };
  for (std::int32_t root = first_root_[index]; root < first_root_[index + 1]; ++root) {
    PointNumbers& numbers =
        numbers_of_side.try_emplace(side_of_root_[root], &patch->nodes).first->second;
    Cut(roots_[root], whole, [&](const Corners& t) {
      AreaPatch::Triangle triangle{{}, AreaOf(t)};
      for (int k = 0; k < 3; ++k) {
        triangle.node[k] = numbers.Of(t[k]);
        patch->weight.resize(patch->nodes.size());
        patch->weight[triangle.node[k]] += triangle.area / 3;
      }
      patch->triangles.push_back(triangle);
    });
  }
  std::vector<Sphere> spheres;
  const auto count = static_cast<std::int32_t>(patch->triangles.size());
  for (std::int32_t first = 0; first < count; first += kLeafTriangles) {
    const std::int32_t last = std::min(count, first + kLeafTriangles);
    std::vector<Vec3> corners;
    for (std::int32_t i = first; i < last; ++i) {
      for (const std::int32_t node : patch->triangles[i].node)
        corners.push_back(patch->nodes[node]);
    }
    patch->leaves.push_back({first, last});
    spheres.push_back(SphereAround(corners.data(), corners.size()));
  }
  patch->tree = SphereTree(std::move(spheres));
  return patch;
}

}  // namespace contact_toolkit
