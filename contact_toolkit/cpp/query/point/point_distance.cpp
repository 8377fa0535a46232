#include "query/point/point_distance.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <utility>

#include "base/tolerances.h"
#include "kernels/kernels.h"
#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

CullPoint ForCulling(const Bvh& bvh, const Vec3& p) {
  const Vec3 local = bvh.Local(p);
  const double far = std::max({std::abs(local.x), std::abs(local.y), std::abs(local.z)});
  CullPoint point;
  for (int i = 0; i < 3; ++i) point.p[i] = static_cast<float>(local[i]);
  point.slack = static_cast<float>(kCullingSlack * (far + bvh.size));
  return point;
}

class Search {
 public:
  Search(const Bvh& bvh, const Vec3& p, double squared_bound) : bvh_(bvh), p_(p) {
    best_.squared_distance = squared_bound;
    Tighten();
  }

  void Run(std::int32_t tried_slot) {
    ForEachNear([&](std::int32_t slot) {
      if (slot != tried_slot) Try(slot);
    });
  }

  // Calls visit(slot) for the facets that may be within the limit, which it may lower.
  template <typename Visit>
  void ForEachNear(const Visit& visit) const {
    const CullPoint point = ForCulling(bvh_, p_);
    Entry shallow[kStack];
    std::unique_ptr<Entry[]> deep;
    const int needed = bvh_.depth * (kBvhWidth - 1) + kBvhWidth;
    if (needed > kStack) deep.reset(new Entry[needed]);
    Entry* const stack = deep ? deep.get() : shallow;
    int size = 0;
    stack[size++] = {0, 0};
    while (size > 0) {
      const Entry entry = stack[--size];
      if (entry.bound > limit_) continue;
      const BvhNode& node = bvh_.nodes[entry.index];
      alignas(32) float bounds[kBvhWidth];
      unsigned near = node.bottom() ? kernels_.point_facet_bounds(node, bvh_.blocks[node.block],
                                                                  point, limit_, bounds)
                                    : kernels_.point_box_bounds(node, point, limit_, bounds);
      // The children worth a visit, the furthest first.
      Entry* const first = stack + size;
      Entry* last = first;
      for (; near != 0; near &= near - 1) {
        const int k = std::countr_zero(near);
        const float bound = bounds[k];
        Entry* at = last++;
        for (; at > first && at[-1].bound < bound; --at) *at = at[-1];
        *at = {bound, node.child[k]};
      }
      if (node.bottom()) {
        while (last > first) {
          const Entry facet = *--last;
          if (!(facet.bound > limit_)) visit(facet.index);
        }
      }
      size = static_cast<int>(last - stack);
    }
  }

  // Takes the facet of a slot if it is closer than the best, or as close and of a lower index.
  void Try(std::int32_t slot) {
    const double* c = bvh_.slot_coordinates.data() + 9 * static_cast<std::size_t>(slot);
    const Vec3 corner[3] = {{c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]}};
    if (bvh_.slot_thin[slot]) {
      TryInside<long double>(slot, corner);
    } else if (TryInside<double>(slot, corner)) {
      return;
    }
    TryEdge(slot, corner[0], corner[1], 0b001, 0b010);
    TryEdge(slot, corner[0], corner[2], 0b001, 0b100);
    TryEdge(slot, corner[1], corner[2], 0b010, 0b100);
  }

  // Looks no farther than this.
  void LimitTo(double distance) { limit_ = RoundedUp(distance * distance); }

  // Whether a facet at this squared distance or farther cannot be the closest.
  bool Settled(double squared) const { return squared > best_.squared_distance; }

  ClosestPoint Take() const { return best_.slot < 0 ? ClosestPoint{} : best_; }

 private:
  struct Entry {
    float bound;
    std::int32_t index;
  };
  static constexpr int kStack = 16 * kBvhWidth;  // more than a million facets need

  // In extended precision where the facet is thin: the foot would miss it by its width otherwise.
  template <class T>
  bool TryInside(std::int32_t slot, const Vec3 (&corner)[3]) {
    const auto from_corner = [&](const Vec3& q) {
      return Vec<T>{T(q.x) - corner[0].x, T(q.y) - corner[0].y, T(q.z) - corner[0].z};
    };
    const Vec<T> u = from_corner(corner[1]), v = from_corner(corner[2]), w = from_corner(p_);
    const Vec<T> n = Cross(u, v);
    const T whole = Dot(n, n);
    const T along_u = Dot(n, Cross(w, v)), along_v = Dot(n, Cross(u, w));
    if (!(along_u > 0 && along_v > 0 && along_u + along_v < whole)) return false;
    // A point of the facet even where the plane is inaccurate, so never too close.
    const Vec<T> to_foot = (along_u / whole) * u + (along_v / whole) * v;
    const Vec3 foot =
        corner[0] + Vec3{static_cast<double>(to_foot.x), static_cast<double>(to_foot.y),
                         static_cast<double>(to_foot.z)};
    Keep(slot, foot, SquaredNorm(p_ - foot), 0b111);
    return true;
  }

  // Corners come in ascending order of their vertices, so both facets of an edge compute the same
  // bits.
  void TryEdge(std::int32_t slot, const Vec3& a, const Vec3& b, std::uint8_t bit_a,
               std::uint8_t bit_b) {
    const Vec3 u = b - a, from_a = p_ - a;
    const double along = Dot(from_a, u), whole = SquaredNorm(u);
    if (!(along > 0)) {
      Keep(slot, a, SquaredNorm(from_a), bit_a);
    } else if (!(along < whole)) {
      Keep(slot, b, SquaredNorm(p_ - b), bit_b);
    } else {
      const Vec3 foot = a + (along / whole) * u;
      Keep(slot, foot, SquaredNorm(p_ - foot), bit_a | bit_b);
    }
  }

  void Keep(std::int32_t slot, const Vec3& point, double squared, std::uint8_t corners) {
    if (squared > best_.squared_distance) return;
    const bool closer = squared < best_.squared_distance;
    if (!closer && best_.slot >= 0 && bvh_.slot_facet[best_.slot] <= bvh_.slot_facet[slot]) return;
    best_ = {squared, point, slot, corners};
    if (closer) Tighten();
  }

  // So that a facet as close as the best is still looked at.
  static float RoundedUp(double squared) { return static_cast<float>(squared) * (1 + 1e-6f); }
  void Tighten() { limit_ = RoundedUp(best_.squared_distance); }

  const Bvh& bvh_;
  const Kernels& kernels_ = ActiveKernels();
  const Vec3 p_;
  ClosestPoint best_;
  float limit_;
};

// The edge of a facet joining two of its vertices.
std::int32_t EdgeBetween(const CollisionMesh& mesh, std::int32_t facet, std::int32_t a,
                         std::int32_t b) {
  for (const std::int32_t edge : mesh.face_edges()[facet]) {
    const auto& ends = mesh.edges()[edge];
    if (ends[0] == std::min(a, b) && ends[1] == std::max(a, b)) return edge;
  }
  return mesh.face_edges()[facet][0];  // a facet that repeats a vertex
}

}  // namespace

ClosestPoint FindClosestPoint(const Bvh& bvh, const Vec3& p, double squared_bound,
                              std::int32_t hint_slot) {
  Search search(bvh, p, squared_bound);
  if (hint_slot >= 0) search.Try(hint_slot);
  search.Run(hint_slot);
  return search.Take();
}

double FindDistanceToOthers(const Bvh& bvh, const Vec3& p,
                            std::span<const std::int32_t> group_of_facet,
                            std::span<const std::int32_t> groups, double bound) {
  Search search(bvh, p, bound * bound);
  search.ForEachNear([&](std::int32_t slot) {
    const std::int32_t group = group_of_facet[bvh.slot_facet[slot]];
    if (std::ranges::find(groups, group) == groups.end()) search.Try(slot);
  });
  return std::min(bound, std::sqrt(search.Take().squared_distance));
}

void FindNearFacets(const Bvh& bvh, const Vec3& p, double margin, std::int32_t hint_slot,
                    std::vector<NearFacet>* facets) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  facets->clear();
  double least = kInfinity;
  Search around(bvh, p, kInfinity);
  const auto measure = [&](std::int32_t slot) {
    Search alone(bvh, p, kInfinity);
    alone.Try(slot);
    const double distance = std::sqrt(alone.Take().squared_distance);
    facets->push_back({std::nextafter(static_cast<float>(distance), 0.0f), slot});
    if (distance < least) {
      least = distance;
      around.LimitTo(least + margin);
    }
  };
  if (hint_slot >= 0) measure(hint_slot);
  around.ForEachNear([&](std::int32_t slot) {
    if (slot != hint_slot) measure(slot);
  });
  std::erase_if(*facets, [&](const NearFacet& f) { return f.distance > least + margin; });
  std::ranges::sort(*facets, {}, [](const NearFacet& f) { return std::pair(f.distance, f.slot); });
}

ClosestPoint FindClosestAmong(const Bvh& bvh, const Vec3& p, std::span<const NearFacet> facets,
                              double motion) {
  Search search(bvh, p, std::numeric_limits<double>::infinity());
  for (const auto& [distance, slot] : facets) {
    const double least = std::max(0.0, distance - motion);
    if (search.Settled(least * least)) break;
    search.Try(slot);
  }
  return search.Take();
}

Feature FeatureOf(const CollisionMesh& mesh, const ClosestPoint& closest) {
  const auto& vertices = mesh.bvh().slot_vertices[closest.slot];
  const std::int32_t facet = mesh.bvh().slot_facet[closest.slot];
  switch (std::popcount(closest.corners)) {
    case 1:
      return {FeatureKind::kVertex, vertices[std::countr_zero(closest.corners)]};
    case 2: {
      const int low = std::countr_zero(closest.corners);
      const int high = std::bit_width(closest.corners) - 1;
      return {FeatureKind::kEdge, EdgeBetween(mesh, facet, vertices[low], vertices[high])};
    }
    default:
      return {FeatureKind::kFacet, facet};
  }
}

SignedDistance SignOf(const CollisionMesh& mesh, const Vec3& p, const ClosestPoint& closest) {
  SignedDistance result;
  result.slot = closest.slot;
  result.facet = mesh.bvh().slot_facet[closest.slot];
  result.point = closest.point;
  result.feature = FeatureOf(mesh, closest);
  const auto [kind, index] = result.feature;
  const double distance = std::sqrt(closest.squared_distance);
  if (kind == FeatureKind::kFacet) {
    // Linear in p, unlike the distance to the rounded foot; only a thin facet's plane is worse.
    result.gradient = mesh.face_normals()[index];
    const double height = Dot(p - mesh.vertices()[mesh.faces()[index][0]], result.gradient);
    result.distance = mesh.bvh().slot_thin[closest.slot] ? std::copysign(distance, height) : height;
    return result;
  }
  const Vec3& normal =
      kind == FeatureKind::kVertex ? mesh.vertex_normals()[index] : mesh.edge_normals()[index];
  const Vec3 offset = p - closest.point;
  const double sign = Dot(offset, normal) < 0 ? -1 : 1;
  result.distance = sign * distance;
  // The offset's direction is noise where its length is.
  const bool on_surface = !(distance > kOnSurface * mesh.bvh().size);
  result.gradient = on_surface ? Normalized(normal) : (sign / distance) * offset;
  return result;
}

SignedDistance FindSignedDistance(const CollisionMesh& mesh, const Vec3& p,
                                  std::int32_t hint_slot) {
  return SignOf(
      mesh, p, FindClosestPoint(mesh.bvh(), p, std::numeric_limits<double>::infinity(), hint_slot));
}

}  // namespace contact_toolkit
