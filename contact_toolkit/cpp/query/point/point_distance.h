// The point of a mesh closest to a given point, and the signed distance of a point from a closed
// mesh. Exact: single precision only culls, conservatively; what is reported is computed in double.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "math/vec.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

// Among equally close facets the one of the lowest index is reported, so the answer depends on
// neither the traversal nor the hint.
struct ClosestPoint {
  double squared_distance = std::numeric_limits<double>::infinity();
  Vec3 point;
  std::int32_t slot = -1;    // see Bvh; -1: nothing within the bound
  std::uint8_t corners = 0;  // bit k: the point depends on corner k of the slot. One bit: a vertex,
                             // two: an edge, three: the facet's inside
};

// The closest point no further than `squared_bound`. `hint_slot` is a guess that changes the time
// taken and nothing else; -1 for none.
ClosestPoint FindClosestPoint(const Bvh& bvh, const Vec3& p,
                              double squared_bound = std::numeric_limits<double>::infinity(),
                              std::int32_t hint_slot = -1);

// [m] The distance of p from the facets that are of none of these few groups, or the bound where
// none is closer.
double FindDistanceToOthers(const Bvh& bvh, const Vec3& p,
                            std::span<const std::int32_t> group_of_facet,
                            std::span<const std::int32_t> groups, double bound);

// A facet by its slot, and its distance [m] rounded down from a point.
struct NearFacet {
  float distance;
  std::int32_t slot;
};

// Replaces what `facets` held by the facets no more than `margin` [m] farther away than the closest
// one, nearest first. The hint is as for FindClosestPoint().
void FindNearFacets(const Bvh& bvh, const Vec3& p, double margin, std::int32_t hint_slot,
                    std::vector<NearFacet>* facets);

// What FindClosestPoint() finds, when the closest facets are among those given, nearest first, and
// none has come closer to p than its distance less `motion` [m].
ClosestPoint FindClosestAmong(const Bvh& bvh, const Vec3& p, std::span<const NearFacet> facets,
                              double motion);

// The vertex, edge or facet of the mesh that a closest point lies on.
Feature FeatureOf(const CollisionMesh& mesh, const ClosestPoint& closest);

struct SignedDistance {
  double distance = 0;  // negative inside
  Vec3 gradient;        // unit, outwards; on the surface the pseudonormal of the feature
  Vec3 point;           // closest point of the surface
  std::int32_t facet = -1;
  std::int32_t slot = -1;  // of the facet, a good hint for a neighbouring point
  Feature feature{};       // that the closest point lies on
};

// The sign is that of the closest feature's angle-weighted pseudonormal (Baerentzen and Aanaes,
// IEEE TVCG 11(3), 2005). On an open surface it tells the side, except where the feature is a
// boundary.
SignedDistance FindSignedDistance(const CollisionMesh& mesh, const Vec3& p,
                                  std::int32_t hint_slot = -1);
// The same from a closest point already found.
SignedDistance SignOf(const CollisionMesh& mesh, const Vec3& p, const ClosestPoint& closest);

}  // namespace contact_toolkit
