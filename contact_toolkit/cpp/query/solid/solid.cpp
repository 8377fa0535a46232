#include "query/solid/solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/tolerances.h"
#include "query/solid/winding.h"
#include "query/witness/witness.h"

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMostOpen = 0.05;  // [-] of a nearly closed mesh; a box without its lid has 0.10
constexpr int kSamples = 512;       // facets, spread over the area, that tell how open a mesh is
constexpr double kBeside = 1e-7;  // [-] of the mesh's size: where a facet's two sides are looked at
constexpr int kMostClusters = 1000;  // beyond, nobody looks which of them overlap

using Corners = std::array<Vec3, 3>;

Corners CornersOf(const CollisionMesh& mesh, std::int32_t f) {
  const auto& [a, b, c] = mesh.faces()[f];
  return {mesh.vertices()[a], mesh.vertices()[b], mesh.vertices()[c]};
}

Corners Turned(const Corners& t) { return {t[0], t[2], t[1]}; }

double VolumeUnder(const Corners& t, const Vec3& origin) {
  return Dot(t[0] - origin, Cross(t[1] - t[0], t[2] - t[0])) / 6;
}

struct Box {
  Vec3 lower{kInfinity, kInfinity, kInfinity}, upper{-kInfinity, -kInfinity, -kInfinity};
  void Add(const Vec3& p) {
    for (int k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], p[k]);
      upper[k] = std::max(upper[k], p[k]);
    }
  }
  bool Meets(const Box& other) const {
    for (int k = 0; k < 3; ++k) {
      if (lower[k] > other.upper[k] || other.lower[k] > upper[k]) return false;
    }
    return true;
  }
};

bool IsClean(const CollisionMesh& mesh) {
  return mesh.defects().closed() && mesh.defects().duplicate_facets.empty();
}

bool IsOnePiece(const CollisionMesh& mesh) {
  std::vector<std::int32_t> parent(mesh.vertices().size());
  for (std::size_t v = 0; v < parent.size(); ++v) parent[v] = static_cast<std::int32_t>(v);
  const auto root = [&](std::int32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& [a, b] : mesh.edges()) parent[root(a)] = root(b);
  const std::int32_t first = root(mesh.faces()[0][0]);
  return std::ranges::all_of(mesh.faces(), [&](const auto& f) { return root(f[0]) == first; });
}

}  // namespace

struct Solid::Builder {
  explicit Builder(Solid* made) : solid(*made), mesh(*made->given_) {}

  void Run() {
    winding = FindWinding(mesh);
    solid.repairs_.duplicates = winding.duplicates;
    solid.repairs_.collapsed = winding.collapsed;
    MeasureClusters();
    TurnStrayClusters();
    FindOverlaps();
    std::vector<Corners> boundary;
    double& volume = solid.volume_;
    for (std::int32_t f = 0; f < count(); ++f) {
      if (winding.turn[f] == 0) continue;
      boundary.push_back(Wound(f));
      volume += VolumeUnder(boundary.back(), middle);
    }
    auto tree = std::make_unique<const WindingTree>(std::move(boundary));
    if (!winding.balanced) solid.openness_ = Openness(*tree);
    if (!(solid.openness_ <= kMostOpen)) {
      solid.kind_ = SolidKind::kOpen;
    } else if (!(volume > 0)) {
      solid.kind_ = winding.balanced ? SolidKind::kInsideOut : SolidKind::kOpen;
    } else {
      solid.kind_ = winding.balanced ? SolidKind::kClosed : SolidKind::kNearlyClosed;
      FindInner(*tree);
    }
    MakeMesh();
    if (!solid.has_inside()) return;
    FlagAmbiguous();
    if (!solid.ambiguous_vertex_.empty()) solid.winding_ = std::move(tree);
  }

  std::int32_t count() const { return static_cast<std::int32_t>(mesh.faces().size()); }

  Corners Wound(std::int32_t f) const {
    const Corners corners = CornersOf(mesh, f);
    return winding.turn[f] < 0 ? Turned(corners) : corners;
  }

  void MeasureClusters() {
    boxes.resize(winding.num_clusters);
    volumes.assign(winding.num_clusters, 0);
    overlaps.assign(winding.num_clusters, 0);
    facets_of.resize(winding.num_clusters);
    for (std::int32_t f = 0; f < count(); ++f) {
      if (winding.turn[f] == 0) continue;
      const std::int32_t c = winding.cluster[f];
      facets_of[c].push_back(f);
      const Corners corners = Wound(f);
      for (const Vec3& p : corners) boxes[c].Add(p);
      volumes[c] += VolumeUnder(corners, middle);
    }
  }

  bool many() const { return winding.num_clusters > 1 && winding.num_clusters <= kMostClusters; }

  // A closed part that is inside out and in no other part, while others are not, is turned.
  void TurnStrayClusters() {
    if (!many() || !std::ranges::any_of(volumes, [](double v) { return v > 0; })) return;
    for (std::int32_t c = 0; c < winding.num_clusters; ++c) {
      if (!(volumes[c] < 0) || winding.cluster_open[c]) continue;
      const Vec3 p = CornersOf(mesh, facets_of[c].front())[0];
      double around = 0;
      for (std::int32_t other = 0; other < winding.num_clusters; ++other) {
        if (other != c && boxes[other].Meets(boxes[c])) around += WindingAround(p, other);
      }
      if (around > 0.5) continue;  // a cavity
      volumes[c] = -volumes[c];
      for (const std::int32_t f : facets_of[c]) {
        winding.turn[f] = static_cast<std::int8_t>(-winding.turn[f]);
      }
    }
  }

  double WindingAround(const Vec3& p, std::int32_t cluster) const {
    double sum = 0;
    for (const std::int32_t f : facets_of[cluster]) sum += WindingOf(Wound(f), p);
    return sum;
  }

  // Which parts touch or cross others, so that their facets may lie within the solid.
  void FindOverlaps() {
    if (!many()) return;
    std::map<std::int32_t, std::unique_ptr<const CollisionMesh>> parts;
    const auto part = [&](std::int32_t c) -> const CollisionMesh& {
      auto& kept = parts[c];
      if (kept) return *kept;
      std::vector<CollisionMesh::Triple> faces;
      for (const std::int32_t f : facets_of[c]) faces.push_back(mesh.faces()[f]);
      kept = std::make_unique<const CollisionMesh>(mesh.vertices(), faces);
      return *kept;
    };
    for (std::int32_t a = 0; a < winding.num_clusters; ++a) {
      for (std::int32_t b = a + 1; b < winding.num_clusters; ++b) {
        if (winding.cluster_open[a] || winding.cluster_open[b]) continue;
        if (!boxes[a].Meets(boxes[b]) || (overlaps[a] && overlaps[b])) continue;
        // Two that are solid may also lie one within the other; a cavity may well.
        const bool solids = volumes[a] > 0 && volumes[b] > 0;
        if (Intersects(part(a), part(b), Pose{}) || (solids && (Within(a, b) || Within(b, a)))) {
          overlaps[a] = overlaps[b] = 1;
        }
      }
    }
  }

  bool Within(std::int32_t inner, std::int32_t outer) const {
    return WindingAround(CornersOf(mesh, facets_of[inner].front())[0], outer) > 0.5;
  }

  // Next to a closed surface the winding number is a whole number and a half, counting none of what
  // lies in the facet's own plane.
  double Openness(const WindingTree& tree) const {
    double area = 0;
    for (std::int32_t f = 0; f < count(); ++f) area += AreaOf(f);
    const double share = area / kSamples;
    double passed = 0, next = 0.5 * share, sum = 0;
    int samples = 0;
    for (const std::int32_t f : mesh.bvh().slot_facet) {
      passed += AreaOf(f);
      for (bool first = true; next < passed; next += share, first = false) {
        if (!first) continue;
        const Corners t = CornersOf(mesh, f);
        const double weight = std::max(1.0, std::floor((passed - next) / share) + 1);
        const double at = tree.At((t[0] + t[1] + t[2]) / 3) - 0.5;
        sum += weight * std::abs(at - std::round(at));
        samples += static_cast<int>(weight);
      }
    }
    return samples > 0 ? sum / samples : 0.5;
  }

  double AreaOf(std::int32_t f) const {
    if (winding.turn[f] == 0) return 0;
    const Corners t = CornersOf(mesh, f);
    return 0.5 * Norm(Cross(t[1] - t[0], t[2] - t[0]));
  }

  // Facets with the solid on both sides: of walls between chambers, of shells that overlap.
  void FindInner(const WindingTree& tree) {
    const std::vector<std::uint8_t> is_collapsed = Marked(winding.collapsed);
    const std::vector<std::uint8_t> is_duplicate = Marked(winding.duplicates);
    for (std::int32_t f = 0; f < count(); ++f) {
      if (is_collapsed[f] || is_duplicate[f]) continue;
      const bool doubtful = winding.turn[f] == 0 || winding.sheet_branches[winding.sheet[f]] ||
                            overlaps[winding.cluster[f]];
      if (doubtful && IsInner(f, tree)) solid.repairs_.inner.push_back(f);
    }
  }

  std::vector<std::uint8_t> Marked(const std::vector<std::int32_t>& facets) const {
    std::vector<std::uint8_t> marked(count(), 0);
    for (const std::int32_t f : facets) marked[f] = 1;
    return marked;
  }

  bool IsInner(std::int32_t f, const WindingTree& tree) const {
    const Corners t = CornersOf(mesh, f);
    const Vec3 center = (t[0] + t[1] + t[2]) / 3;
    const Vec3 step = kBeside * mesh.diagonal() * mesh.face_normals()[f];
    for (const Vec3& corner : {center, t[0], t[1], t[2]}) {
      const Vec3 p = center + 0.98 * (corner - center);
      // Behind a facet of the boundary it is once more enclosed than in front.
      if (winding.turn[f] >= 0 && !tree.Encloses(p + step)) return false;
      if (winding.turn[f] <= 0 && !tree.Encloses(p - step)) return false;
    }
    return true;
  }

  void MakeMesh() {
    std::vector<std::uint8_t> out = Marked(solid.repairs_.inner);
    for (const auto* facets : {&winding.collapsed, &winding.duplicates}) {
      for (const std::int32_t f : *facets) out[f] = 1;
    }
    std::vector<CollisionMesh::Triple> faces;
    for (std::int32_t f = 0; f < count(); ++f) {
      if (out[f]) continue;
      auto face = mesh.faces()[f];
      if (winding.turn[f] < 0) {
        std::swap(face[1], face[2]);
        solid.repairs_.turned.push_back(f);
      }
      faces.push_back(face);
      solid.facet_given_.push_back(f);
    }
    if (!solid.repairs_.any() || faces.empty()) {
      solid.facet_given_.clear();
      solid.repairs_ = {};
      return;
    }
    solid.mesh_ = std::make_shared<const CollisionMesh>(mesh.vertices(), faces);
  }

  // Where the pseudonormal of the closest feature may be wrong.
  void FlagAmbiguous() {
    const CollisionMesh& made = *solid.mesh_;
    std::vector<std::uint8_t> flags(made.vertices().size(), 0);
    bool any = false;
    const MeshDefects& defects = made.defects();
    for (const auto* edges :
         {&defects.open_edges, &defects.non_manifold_edges, &defects.inconsistent_edges}) {
      for (const std::int32_t edge : *edges) {
        for (const std::int32_t v : made.edges()[edge]) flags[v] = 1;
        any = true;
      }
    }
    std::vector<std::int32_t> cluster_at(made.vertices().size(), -1);
    for (std::size_t f = 0; f < made.faces().size(); ++f) {
      const std::int32_t cluster = winding.cluster[solid.FacetGiven(static_cast<std::int32_t>(f))];
      for (const std::int32_t v : made.faces()[f]) {
        const bool shared = cluster_at[v] >= 0 && cluster_at[v] != cluster;
        if (shared || overlaps[cluster]) flags[v] = 1, any = true;
        cluster_at[v] = cluster;
      }
    }
    if (any) solid.ambiguous_vertex_ = std::move(flags);
  }

  Solid& solid;
  const CollisionMesh& mesh;
  const Vec3 middle = 0.5 * (mesh.lower() + mesh.upper());
  Winding winding;
  std::vector<std::vector<std::int32_t>> facets_of;  // of clusters
  std::vector<Box> boxes;                            // likewise
  std::vector<double> volumes;                       // likewise [m³]
  std::vector<std::uint8_t> overlaps;                // likewise
};

Solid::Solid(std::shared_ptr<const CollisionMesh> given) : given_(std::move(given)), mesh_(given_) {
  if (IsClean(*given_) && IsOnePiece(*given_)) {
    volume_ = given_->volume();
    if (!(volume_ > 0)) kind_ = SolidKind::kInsideOut;
    return;
  }
  Builder(this).Run();
}

bool Solid::Ambiguous(const Feature& feature) const {
  const auto flagged = [this](std::int32_t v) { return ambiguous_vertex_[v] != 0; };
  switch (feature.kind) {
    case FeatureKind::kVertex:
      return flagged(feature.index);
    case FeatureKind::kEdge:
      return std::ranges::all_of(mesh_->edges()[feature.index], flagged);
    default:
      return std::ranges::all_of(mesh_->faces()[feature.index], flagged);
  }
}

SignedDistance Solid::SignAt(const Vec3& p, const ClosestPoint& closest) const {
  SignedDistance at = SignOf(*mesh_, p, closest);
  if (!winding_ || !Ambiguous(at.feature)) return at;
  // On the surface there is no side.
  if (!(std::abs(at.distance) > kOnSurface * mesh_->bvh().size)) return at;
  if (winding_->Encloses(p) != (at.distance < 0)) {
    at.distance = -at.distance;
    at.gradient = -at.gradient;
  }
  return at;
}

SignedDistance Solid::FindSignedDistance(const Vec3& p, std::int32_t hint_slot) const {
  return SignAt(p, FindClosestPoint(mesh_->bvh(), p, kInfinity, hint_slot));
}

}  // namespace contact_toolkit
