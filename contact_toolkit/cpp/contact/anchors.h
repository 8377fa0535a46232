// Anchors of tangential springs: state between accepted steps, immutable once made.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/archive.h"
#include "base/lazy.h"
#include "math/vec.h"

namespace contact_toolkit {

// A point of A and a point of B that were one when the spring had no stretch; their offset within
// the tangent plane is the stretch.
struct Anchor {
  std::uint64_t key;  // of the spring
  Vec3 p_AQ, p_BQ;    // fixed in A, fixed in B
  double stiffness;   // [N/m] of the normal spring then
  bool sliding;       // was on the friction cone and has neither stopped nor reversed since
};

// The anchors of one pair, in the order of its springs at the last accepted step.
class AnchorSet {
 public:
  AnchorSet() = default;
  explicit AnchorSet(std::vector<Anchor> anchors) : anchors_(std::move(anchors)) {}

  const std::vector<Anchor>& anchors() const { return anchors_; }

  // Index of the anchor with this key, or −1. `hint`: where it would be had nothing changed.
  std::int32_t Find(std::uint64_t key, std::size_t hint) const {
    if (hint < anchors_.size() && anchors_[hint].key == key) return static_cast<std::int32_t>(hint);
    return Search(key);
  }

 private:
  std::int32_t Search(std::uint64_t key) const;
  friend auto Fields(Of<AnchorSet> auto& self) { return std::tie(self.anchors_); }

  // An open-addressing hash table of indices; its length is a power of two.
  using Slots = std::vector<std::int32_t>;
  Slots* MakeSlots() const;

  std::vector<Anchor> anchors_;
  Lazy<Slots> slots_;  // seldom needed: springs mostly keep their order
};

}  // namespace contact_toolkit
