// Solid: the inside of a mesh as strangers make them. A clean closed mesh is its own boundary. One
// with doubled, turned or stray facets is healed, for the sign alone and on a copy; one with a hole
// or crack far from most of its surface gets its signs there from the winding number.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "query/point/point_distance.h"
#include "query/solid/winding_number.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

enum class SolidKind {
  kClosed,        // bounds a solid: every point is inside or outside
  kNearlyClosed,  // has holes, small for most of its surface
  kOpen,          // has no inside
  kInsideOut,     // closed, with the outside inside: taken to have no inside
};

// What of the mesh as given has no part in the boundary, or another part than given; facets.
struct SolidRepairs {
  std::vector<std::int32_t> turned, duplicates, collapsed, inner;
  bool any() const {
    return !(turned.empty() && duplicates.empty() && collapsed.empty() && inner.empty());
  }
};

// Immutable once built; shared between threads freely.
class Solid {
 public:
  explicit Solid(std::shared_ptr<const CollisionMesh> given);

  const CollisionMesh& given() const { return *given_; }
  // The boundary: the mesh given, or a copy that is healed. Facets in the order given.
  const std::shared_ptr<const CollisionMesh>& mesh() const { return mesh_; }
  SolidKind kind() const { return kind_; }
  bool has_inside() const {
    return kind_ == SolidKind::kClosed || kind_ == SolidKind::kNearlyClosed;
  }
  const SolidRepairs& repairs() const { return repairs_; }
  // [m³] Within its facets, wound as they are taken; what several parts share counts for each.
  double volume() const { return volume_; }
  // [-] How far, on average over the surface, the winding number next to it is from that next to a
  // closed one: 0 closed, 0.5 a flat sheet.
  double openness() const { return openness_; }
  // Index into the facets given of a facet of mesh().
  std::int32_t FacetGiven(std::int32_t facet) const {
    return facet_given_.empty() ? facet : facet_given_[facet];
  }

  // The signed distance from a closest point of mesh() already found; as SignOf() but where the
  // closest feature cannot tell the side.
  SignedDistance SignAt(const Vec3& p, const ClosestPoint& closest) const;
  SignedDistance FindSignedDistance(const Vec3& p, std::int32_t hint_slot = -1) const;

 private:
  struct Builder;

  bool Ambiguous(const Feature& feature) const;

  std::shared_ptr<const CollisionMesh> given_, mesh_;
  SolidKind kind_ = SolidKind::kClosed;
  SolidRepairs repairs_;
  double openness_ = 0, volume_ = 0;
  std::vector<std::int32_t> facet_given_;       // empty: all of them
  std::vector<std::uint8_t> ambiguous_vertex_;  // of mesh(); empty: none
  std::unique_ptr<const WindingTree> winding_;  // null where no feature is ambiguous
};

}  // namespace contact_toolkit
