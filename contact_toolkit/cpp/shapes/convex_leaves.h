// What the convex queries see of a shape: a hierarchy whose every slot holds a convex point set, be
// it a facet of a mesh or a piece of a ConvexPieces.
#pragma once

#include <cstdint>
#include <span>

#include "math/vec.h"
#include "shapes/bvh.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

class ConvexLeaves {
 public:
  explicit ConvexLeaves(const CollisionMesh& mesh)
      : mesh_(&mesh),
        bvh_(&mesh.bvh()),
        points_(reinterpret_cast<const Vec3*>(mesh.bvh().slot_coordinates.data())) {}
  // Leaf i has the points first[i] to first[i + 1].
  ConvexLeaves(const Bvh& bvh, std::span<const Vec3> points, std::span<const std::int32_t> first)
      : bvh_(&bvh), points_(points.data()), first_(first.data()) {}

  const Bvh& bvh() const { return *bvh_; }
  // Null when the leaves are not facets.
  const CollisionMesh* mesh() const { return mesh_; }
  // The facet's or the piece's own index.
  std::int32_t index(int slot) const { return bvh_->slot_facet[slot]; }
  std::span<const Vec3> points(int slot) const {
    if (mesh_ != nullptr) return {points_ + 3 * slot, 3};
    const std::int32_t i = index(slot);
    return {points_ + first_[i], points_ + first_[i + 1]};
  }

 private:
  const CollisionMesh* mesh_ = nullptr;
  const Bvh* bvh_;
  const Vec3* points_;  // of a mesh: three a slot, in slot order
  const std::int32_t* first_ = nullptr;
};

}  // namespace contact_toolkit
