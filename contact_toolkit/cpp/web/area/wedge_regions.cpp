#include "web/area/wedge_regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "query/point/point_distance.h"
#include "shapes/sharp_edges.h"

namespace contact_toolkit {
namespace {

constexpr double kInPlane = 1e-12;  // [-] of the mesh's size: what stands out of a plane by less

// What of a triangle lies above a plane by more than `least`: up to four corners.
std::vector<Vec3> Above(const std::array<Vec3, 3>& triangle, const FlatSides::Side& plane,
                        double least) {
  std::vector<Vec3> polygon;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = triangle[k], &b = triangle[(k + 1) % 3];
    const double over_a = Dot(plane.normal, a) - plane.offset - least;
    const double over_b = Dot(plane.normal, b) - plane.offset - least;
    if (over_a > 0) polygon.push_back(a);
    if ((over_a > 0) != (over_b > 0)) polygon.push_back(a + over_a / (over_a - over_b) * (b - a));
  }
  return polygon;
}

}  // namespace

// What of a wedge's sides does not bound it, for it lies beyond another of its planes.
class WedgeRegions::Beyond {
 public:
  Beyond() = default;
  Beyond(const std::vector<Vec3>& vertices, const std::vector<CollisionMesh::Triple>& facets) {
    if (!facets.empty()) bvh_ = BuildBvh(vertices, facets);
  }

  double DistanceFrom(const Vec3& p, double bound) const {
    if (!bvh_) return bound;
    return std::min(bound, std::sqrt(FindClosestPoint(*bvh_, p, bound * bound).squared_distance));
  }

 private:
  std::optional<Bvh> bvh_;
};

WedgeRegions::WedgeRegions(std::shared_ptr<const ProbedSurface> surface,
                           std::shared_ptr<const FlatRegions> flats, double finest)
    : surface_(std::move(surface)), flats_(std::move(flats)), memo_(finest, surface_->mesh()) {
  FindWedges();
  beyond_ = std::vector<Lazy<Beyond>>(wedges_.size());
}

WedgeRegions::~WedgeRegions() = default;

std::int32_t WedgeRegions::Add(Wedge wedge) {
  if (static_cast<std::int32_t>(wedges_.size()) >= RegionMemo::kMostRegions) return -1;
  wedges_.push_back(wedge);
  return static_cast<std::int32_t>(wedges_.size()) - 1;
}

void WedgeRegions::FindWedges() {
  const CollisionMesh& mesh = surface_->mesh();
  const std::vector<std::int32_t>& side_of = flats_->flats().of_facet;
  const auto round = [&](std::int32_t side) { return flats_->side(side).round; };
  std::vector<std::int32_t> sharp = FindSharpEdges(mesh);
  std::erase_if(sharp, [&](std::int32_t edge) {
    const auto [f, g] = mesh.edge_faces()[edge];
    return round(side_of[f]) || round(side_of[g]);
  });
  if (sharp.empty()) return;
  facets_of_.resize(flats_->flats().sides.size());
  // The sides that meet at each vertex, as far as they fit.
  std::vector<std::vector<std::int32_t>> sides_at(mesh.vertices().size());
  for (std::size_t f = 0; f < mesh.faces().size(); ++f) {
    facets_of_[side_of[f]].push_back(static_cast<std::int32_t>(f));
    for (const std::int32_t v : mesh.faces()[f]) {
      if (std::ranges::find(sides_at[v], side_of[f]) == sides_at[v].end()) {
        sides_at[v].push_back(side_of[f]);
      }
    }
  }
  std::map<std::vector<std::int32_t>, std::int32_t> known;
  const auto wedge_of = [&](std::vector<std::int32_t> sides) -> std::int32_t {
    if (sides.size() < 2 || sides.size() > Wedge::kMostSides) return -1;
    if (std::ranges::any_of(sides, round)) return -1;
    std::ranges::sort(sides);
    const auto [entry, added] = known.try_emplace(sides, -1);
    if (added) {
      Wedge wedge;
      std::ranges::copy(sides, wedge.side.begin());
      wedge.count = static_cast<int>(sides.size());
      entry->second = Add(wedge);
    }
    return entry->second;
  };
  std::vector<CollisionMesh::Triple> segments;
  for (const std::int32_t edge : sharp) {
    const auto [a, b] = mesh.edges()[edge];
    const auto [f, g] = mesh.edge_faces()[edge];
    segments.push_back({a, b, b});
    wedges_of_.push_back(
        {wedge_of({side_of[f], side_of[g]}), wedge_of(sides_at[a]), wedge_of(sides_at[b])});
  }
  edges_ = std::make_unique<Bvh>(BuildBvh(mesh.vertices(), segments));
}

KnownRegion WedgeRegions::About(const Vec3& center, double radius) const {
  if (!edges_) return {};
  return memo_.About(center, radius,
                     [&](const Vec3& p, double least) { return Measure(p, least); });
}

// What goes no farther than `least` is of no use.
KnownRegion WedgeRegions::Measure(const Vec3& p, double least) const {
  const ClosestPoint closest = FindClosestPoint(*edges_, p);
  KnownRegion best{-1, least};
  for (const std::int32_t wedge : wedges_of_[edges_->slot_facet[closest.slot]]) {
    if (wedge < 0) continue;
    const double clear = ClearOf(wedge, p);
    if (clear > best.clear) best = {wedge, clear};
  }
  return best;
}

double WedgeRegions::ClearOf(std::int32_t wedge, const Vec3& p) const {
  const CollisionMesh& mesh = surface_->mesh();
  const std::vector<std::int32_t>& side_of = flats_->flats().of_facet;
  const std::span<const std::int32_t> sides(wedges_[wedge].side.data(), wedges_[wedge].count);
  const double others =
      FindDistanceToOthers(mesh.bvh(), p, side_of, sides, 4 * (mesh.diagonal() + Norm(p)));
  double clear = BeyondOf(wedge).DistanceFrom(p, others);
  // A side that comes as near is there all over the ball, as nothing ends it there; of one that
  // does not, such as the end face of a gear in the gap between two teeth, there is only the plane.
  const double around = clear;
  for (const std::int32_t side : sides) {
    const double to_plane = std::abs(Dot(flats_->side(side).normal, p) - flats_->side(side).offset);
    if (to_plane >= clear) continue;
    std::vector<std::int32_t> rest(sides.begin(), sides.end());
    std::erase(rest, side);
    if (FindDistanceToOthers(mesh.bvh(), p, side_of, rest, around) >= around) clear = to_plane;
  }
  return clear;
}

const WedgeRegions::Beyond& WedgeRegions::BeyondOf(std::int32_t index) const {
  return beyond_[index].Get([&] {
    const CollisionMesh& mesh = surface_->mesh();
    const double least = kInPlane * (mesh.diagonal() + Norm(mesh.lower()));
    const Wedge& wedge = wedges_[index];
    std::vector<Vec3> vertices;
    std::vector<CollisionMesh::Triple> facets;
    for (int i = 0; i < wedge.count; ++i) {
      for (int j = 0; j < wedge.count; ++j) {
        if (i == j) continue;
        for (const std::int32_t f : facets_of_[wedge.side[i]]) {
          const auto& [a, b, c] = mesh.faces()[f];
          const std::vector<Vec3> polygon =
              Above({mesh.vertices()[a], mesh.vertices()[b], mesh.vertices()[c]},
                    flats_->side(wedge.side[j]), least);
          const auto first = static_cast<std::int32_t>(vertices.size());
          vertices.insert(vertices.end(), polygon.begin(), polygon.end());
          for (std::int32_t k = 2; k < static_cast<std::int32_t>(polygon.size()); ++k) {
            facets.push_back({first, first + k - 1, first + k});
          }
        }
      }
    }
    return new Beyond(vertices, facets);
  });
}

}  // namespace contact_toolkit
