#include "web/area/area_nodes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/tolerances.h"
#include "query/point/point_distance.h"
#include "shapes/point_numbers.h"
#include "shapes/sharp_edges.h"
#include "web/area/flat_sides.h"

namespace contact_toolkit {
namespace {

constexpr double kFinest = 0.25;   // spacing on sharp edges, as a fraction of the spacing elsewhere
constexpr double kGradedOver = 2;  // spacings over which it grows back
constexpr double kShareOfSide = 0.126;  // the largest triangle, of a flat side's diameter: the
                                        // moment of friction of a square is 1.2 % too large
constexpr int kPatchTriangles = 400;    // at most
constexpr int kMostCuts = 5;            // of a triangle, until its parts are a patch of their own
constexpr double kPatchParts = 4000;    // aimed at
constexpr double kPatchSpacings = 16;   // the longest edge of a triangle
constexpr double kMostPatches = 50000;  // about: a plate of sheet metal under a pea has large ones
constexpr int kLeafTriangles = 8;

double AreaOf(const Corners& t) { return 0.5 * Norm(Cross(t[1] - t[0], t[2] - t[0])); }

// What falls to each node of a patch, by how often the triangles around it are cut: fixed in the
// mesh, so that a node's friction is as stiff whatever of its surroundings bears load.
class NodeShares {
 public:
  explicit NodeShares(std::size_t nodes) {
    for (std::vector<double>& shares : by_cuts_) shares.assign(nodes, 0);
  }

  // Before Give. A triangle that is cut no further stands among those cut more often. One whose
  // parts are a patch of their own leaves the smallest to that.
  void Take(const AreaPatch::Triangle& triangle, int cuts, bool smallest) {
    const int last = smallest ? kMostCuts : cuts;
    for (int k = cuts; k <= last; ++k) {
      for (const std::int32_t i : triangle.node) by_cuts_[k][i] += triangle.area / 3;
    }
  }
  void Give(int cuts, bool smallest, AreaPatch::Triangle* triangle) const {
    const std::vector<double>& shares = by_cuts_[smallest ? kMostCuts : cuts];
    for (int k = 0; k < 3; ++k) {
      triangle->share[k] = shares[triangle->node[k]];
    }
  }

 private:
  std::array<std::vector<double>, kMostCuts + 1> by_cuts_;  // the last: of the smallest
};

// Calls visit(triangle, cuts, smallest) for a triangle and all its parts.
template <typename Visit>
void ForEachPart(std::vector<AreaPatch::Triangle>* triangles, std::int32_t place, int cuts,
                 const Visit& visit) {
  AreaPatch::Triangle& triangle = (*triangles)[place];
  if (triangle.deeper >= 0) return;  // the patch that it is tells its own
  visit(triangle, cuts, triangle.last == place + 1);
  for (std::int32_t i = place + 1; i < triangle.last; i = (*triangles)[i].last) {
    ForEachPart(triangles, i, cuts + 1, visit);
  }
}

void ShareOut(AreaParts* parts) {
  NodeShares shares(parts->nodes.size());
  const auto for_each = [&](const auto& visit) {
    for (const std::int32_t place : parts->place) ForEachPart(&parts->triangles, place, 0, visit);
  };
  for_each([&](const AreaPatch::Triangle& triangle, int cuts, bool smallest) {
    shares.Take(triangle, cuts, smallest);
  });
  for_each([&](AreaPatch::Triangle& triangle, int cuts, bool smallest) {
    shares.Give(cuts, smallest, &triangle);
  });
}

// Of a patch within another: anchors know their nodes by it, so two that touch at once should
// differ. Above the indices of the patches that are not.
std::int32_t NameOf(std::int32_t patch, std::size_t place) {
  std::uint64_t name = (static_cast<std::uint64_t>(patch) << 32 | place) * 0x9e3779b97f4a7c15ull;
  name = (name ^ name >> 29) * 0xbf58476d1ce4e5b9ull;
  return static_cast<std::int32_t>(name >> 34 | 1u << 30);
}

}  // namespace

double RadiusOf(const Corners& triangle) {
  const Vec3 center = CenterOf(triangle);
  double squared = 0;
  for (const Vec3& corner : triangle) squared = std::max(squared, SquaredNorm(corner - center));
  return std::sqrt(squared);
}

AreaNodes::AreaNodes(std::shared_ptr<const CollisionMesh> mesh, double spacing,
                     const RoundLattice& round)
    : mesh_(std::move(mesh)), spacing_(spacing), round_(round) {
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

double AreaNodes::SpacingAt(const Vec3& p, double enough) const {
  if (!sharp_edges_) return spacing_;
  const double reach = kGradedOver * spacing_;
  const double within =
      std::min(reach, reach * (enough / spacing_ - kFinest) / (1 - kFinest) + kTouching * reach);
  const ClosestPoint closest = FindClosestPoint(*sharp_edges_, p, within * within);
  if (closest.slot < 0) return spacing_;
  const double share = std::sqrt(closest.squared_distance) / reach;
  return spacing_ * (kFinest + (1 - kFinest) * share);
}

bool AreaNodes::Splits(const Vec3& a, const Vec3& b) const {
  const double squared = SquaredNorm(b - a);
  if (squared > spacing_ * spacing_) return true;
  if (squared <= kFinest * kFinest * spacing_ * spacing_) return false;
  const double spacing = SpacingAt(0.5 * (a + b), std::sqrt(squared));
  return squared > spacing * spacing;
}

// On the round surface of a lattice.
bool AreaNodes::SplitsRound(const Vec3& a, const Vec3& b) const {
  const Vec3 e = b - a;
  if (!round_.OnSide(a, b)) return SquaredNorm(e) > round_.across * round_.across;
  const double around = std::sqrt(e.x * e.x + e.y * e.y), along = std::abs(e.z);
  if (around > round_.across || along > round_.along) return true;
  if (!sharp_edges_) return false;
  // Of a cylinder's rims.
  const double share = SpacingAt(0.5 * (a + b), spacing_) / spacing_;
  return around > share * round_.across || along > share * round_.along;
}

template <typename Emit>
bool AreaNodes::Cut(const Corners& triangle, const Emit& emit) const {
  if (!round_.IsRound(triangle)) {
    return CutOnce(triangle, [&](const Vec3& a, const Vec3& b) { return Splits(a, b); }, emit);
  }
  return CutInHalves(
      triangle, [&](const Vec3& a, const Vec3& b) { return SplitsRound(a, b); },
      [&](const Vec3& a, const Vec3& b) { return round_.Raised(0.5 * (a + b)); }, emit);
}

// Answers of Splits: the triangles around an edge ask the same several times.
class AreaNodes::AskedEdges {
 public:
  bool Of(const Vec3& a, const Vec3& b, const AreaNodes& nodes) {
    const double squared = SquaredNorm(b - a);
    const auto number = static_cast<std::size_t>(numbers_.Of(0.5 * (a + b)));
    if (number == answers_.size()) answers_.push_back({-1, false});
    Answer& answer = answers_[number];  // the diagonals of a parallelogram share their middle
    if (answer.squared != squared) answer = {squared, nodes.Splits(a, b)};
    return answer.splits;
  }

 private:
  struct Answer {
    double squared;  // of the edge's length
    bool splits;
  };
  std::vector<Vec3> middles_;
  PointNumbers numbers_{&middles_};
  std::vector<Answer> answers_;
};

void AreaNodes::BuildPatches() {
  const double longest =
      std::max(kPatchSpacings * spacing_, 2 * std::sqrt(mesh_->area() / kMostPatches));
  const FlatSides flats = FindFlatSides(*mesh_);
  int triangles = 0;
  double parts = 0;
  Vec3 corner;
  std::vector<Sphere> spheres;
  const auto close = [&] {
    const std::size_t first = first_root_.back();
    if (first == roots_.size()) return;
    spheres.push_back(SphereAround(roots_[first].data(), 3 * (roots_.size() - first)));
    first_root_.push_back(static_cast<std::int32_t>(roots_.size()));
    triangles = 0, parts = 0;
  };
  const std::vector<std::int32_t> sides = FindSides(*mesh_);
  AskedEdges asked;
  first_root_.push_back(0);
  for (const std::int32_t facet : mesh_->bvh().slot_facet) {
    const auto& f = mesh_->faces()[facet];
    const Corners whole{mesh_->vertices()[f[0]], mesh_->vertices()[f[1]], mesh_->vertices()[f[2]]};
    if (!(AreaOf(whole) > 0)) continue;
    const double largest =
        std::min(longest, kShareOfSide * flats.sides[flats.of_facet[facet]].diameter);
    const auto splits = [&](const Vec3& a, const Vec3& b) {
      return SquaredNorm(b - a) > largest * largest && asked.Of(a, b, *this);
    };
    const auto add = [&](const Corners& t) {
      const double cell = round_.IsRound(t) ? round_.across * round_.along : spacing_ * spacing_;
      const double expected = 1 + 4 * AreaOf(t) / cell;
      const bool full = triangles == kPatchTriangles || parts + expected > kPatchParts;
      if (triangles > 0 && (full || Norm(t[0] - corner) > 2 * longest)) close();
      if (triangles == 0) corner = t[0];
      roots_.push_back(t);
      side_of_root_.push_back(sides[facet]);
      ++triangles, parts += expected;
    };
    if (!round_.IsRound(whole)) {
      CutUntil(whole, splits, add);
    } else if (round_.OnSide(whole)) {
      round_.CutSide(whole, add);
    } else {
      add(whole);
    }
  }
  close();
  tree_ = SphereTree(std::move(spheres));
  patches_ = std::vector<Lazy<AreaPatch>>(first_root_.size() - 1);
  parts_ = std::vector<Lazy<AreaParts>>(first_root_.size() - 1);
}

const AreaPatch& AreaNodes::patch(std::int32_t index) const {
  return patches_[index].Get([&] { return MakePatch(index).release(); });
}

const AreaParts& AreaNodes::parts(std::int32_t index) const {
  return parts_[index].Get([&] { return MakeParts(index).release(); });
}

// Numbers the nodes of a patch.
class AreaNodes::Numbering {
 public:
  explicit Numbering(std::vector<Vec3>* nodes) : nodes_(nodes) {}

  // Those that follow lie in this side of the surface.
  void Enter(std::int32_t side) { numbers_ = &of_side_.try_emplace(side, nodes_).first->second; }

  AreaPatch::Triangle Of(const Corners& t) const {
    AreaPatch::Triangle triangle{{}, 0, AreaOf(t)};
    for (int k = 0; k < 3; ++k) triangle.node[k] = numbers_->Of(t[k]);
    return triangle;
  }

 private:
  std::vector<Vec3>* nodes_;
  std::map<std::int32_t, PointNumbers> of_side_;
  PointNumbers* numbers_ = nullptr;
};

std::unique_ptr<AreaPatch> AreaNodes::MakePatch(std::int32_t index) const {
  auto patch = std::make_unique<AreaPatch>();
  Numbering numbering(&patch->nodes);
  for (std::int32_t root = first_root_[index]; root < first_root_[index + 1]; ++root) {
    numbering.Enter(side_of_root_[root]);
    patch->triangles.push_back(numbering.Of(roots_[root]));
    const bool cut = Cut(roots_[root], [](const Corners&) {});
    patch->triangles.back().last = cut ? -1 : static_cast<std::int32_t>(patch->triangles.size());
    patch->has_parts = patch->has_parts || cut;
  }
  NodeShares shares(patch->nodes.size());
  for (const AreaPatch::Triangle& triangle : patch->triangles) shares.Take(triangle, 0, false);
  for (AreaPatch::Triangle& triangle : patch->triangles) shares.Give(0, false, &triangle);
  std::vector<Sphere> spheres;
  const auto count = static_cast<std::int32_t>(patch->triangles.size());
  // Triangles of a round surface turn away from what it touches, each on its own.
  const int in_leaf = round_ ? 1 : kLeafTriangles;
  for (std::int32_t first = 0; first < count; first += in_leaf) {
    const std::int32_t last = std::min(count, first + in_leaf);
    const std::int32_t root = first_root_[index] + first;
    spheres.push_back(SphereAround(roots_[root].data(), 3 * (last - first)));
    double largest = 0;
    for (std::int32_t i = root; i < root + last - first; ++i) {
      largest = std::max(largest, RadiusOf(roots_[i]));
    }
    patch->leaves.push_back({first, last, spheres.back(), largest});
  }
  patch->tree = SphereTree(std::move(spheres));
  return patch;
}

std::unique_ptr<AreaParts> AreaNodes::MakeParts(std::int32_t index) const {
  auto parts = std::make_unique<AreaParts>();
  parts->patch = index;
  Numbering numbering(&parts->nodes);
  // The patch's own nodes first, so that they keep their numbers.
  for (std::int32_t root = first_root_[index]; root < first_root_[index + 1]; ++root) {
    numbering.Enter(side_of_root_[root]);
    numbering.Of(roots_[root]);
  }
  for (std::int32_t root = first_root_[index]; root < first_root_[index + 1]; ++root) {
    numbering.Enter(side_of_root_[root]);
    parts->place.push_back(static_cast<std::int32_t>(parts->triangles.size()));
    AddParts(roots_[root], 0, &numbering, parts.get());
  }
  ShareOut(parts.get());
  return parts;
}

const AreaParts& AreaNodes::parts(const AreaParts::Deeper& deeper) const {
  return deeper.parts.Get([&] {
    auto parts = std::make_unique<AreaParts>();
    parts->patch = deeper.patch;
    Numbering numbering(&parts->nodes);
    numbering.Enter(0);
    parts->place.push_back(0);
    AddParts(deeper.corners, 0, &numbering, parts.get());
    ShareOut(parts.get());
    return parts.release();
  });
}

void AreaNodes::AddParts(const Corners& t, int cuts, Numbering* numbering, AreaParts* parts) const {
  const std::size_t place = parts->triangles.size();
  parts->triangles.push_back(numbering->Of(t));
  if (cuts < kMostCuts) {
    Cut(t, [&](const Corners& part) { AddParts(part, cuts + 1, numbering, parts); });
  } else if (Cut(t, [](const Corners&) {})) {
    parts->triangles[place].deeper = static_cast<std::int32_t>(parts->deeper.size());
    parts->deeper.emplace_back(t, NameOf(parts->patch, place));
  }
  parts->triangles[place].last = static_cast<std::int32_t>(parts->triangles.size());
}

}  // namespace contact_toolkit
