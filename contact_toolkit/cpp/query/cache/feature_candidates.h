// Candidate facet pairs by the features that carry their closest points. All facet pairs around the
// same two features share these points: they are placed once, and hold for all of them when the
// facets around are seen to leave nothing closer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/column.h"
#include "kernels/kernels.h"
#include "query/witness/facet_pair.h"
#include "shapes/mesh.h"

namespace contact_toolkit {

// Facet pairs in the order they were gathered in, with what was found there.
struct FacetCandidates {
  Column<std::int32_t> slot_a, slot_b;
  Column<double> distance;  // [m]
  Column<FeaturePair> features;

  std::size_t size() const { return slot_a.size(); }
};

class FeatureCandidates {
 public:
  // Blocks hold groups of one kind, taken from as many in a row: few enough for their witnesses to
  // stay in the cache, and enough for the blocks to be full.
  static constexpr std::size_t kWindow = 512;

  // All candidates on the same two features, or some of them.
  struct Group {
    FeaturePair features;
    std::int32_t first;         // candidate
    std::int32_t count;         // of candidates
    std::int32_t first_member;  // index into members_
    std::int32_t place;         // where Measure leaves its witness, if it does
    bool doubtful;              // uncertain already at the pose it was formed at
  };

  FeatureCandidates(const PosedPair& pair, const FacetCandidates& candidates);

  // Takes note that the features of the `changed` candidates, in order, are others at this pose.
  void Regroup(const PosedPair& pair, const FacetCandidates& candidates,
               std::span<const std::int32_t> changed);

  // Whether regrouping has left so much behind that forming all groups anew is better.
  bool Sparse() const { return groups_.size() > 4 * static_cast<std::size_t>(formed_) + kWindow; }

  // How many candidates are certainly closest at their features where these were remembered.
  std::size_t Certain() const;

  const Group& group(std::int32_t index) const { return groups_[index]; }

  // By their first candidate.
  const Column<std::int32_t>& order() const { return order_; }

  // Whether there may be other groups on the same features.
  bool MayHaveTwin(std::int32_t index) const { return index >= formed_; }

  // Where Measure leaves the witness of each candidate.
  const Column<std::int32_t>& place() const { return place_; }

  // Places the closest points of the groups that were `near` [m] where they were gathered. Where
  // they are too far or uncertain at this pose the distance is infinite. `alone` are, in order, the
  // near candidates to be measured one by one instead. Returns how many of them were
  // certain at the pose their group was formed at.
  std::size_t Measure(const PosedPair& pair, const FacetCandidates& candidates, double near,
                      Column<FeatureWitness>* witnesses, Column<std::int32_t>* alone) const;

 private:
  struct Sides;
  class BlockWriter;

  std::span<const std::int32_t> Members(const Group& group) const {
    return {&members_[group.first_member], static_cast<std::size_t>(group.count)};
  }
  void FormGroups(const PosedPair& pair, const FacetCandidates& candidates,
                  std::span<const std::int32_t> members);
  void PackGroups(const PosedPair& pair, const FacetCandidates& candidates, std::size_t first);
  static std::span<Group*> SortedByKind(std::span<Group> groups);
  void PackBlock(std::span<const Sides> lanes, const FacetCandidates& candidates);
  void Disband(std::int32_t group, Column<std::int32_t>* members);

  // The place of what has no witness: its distance is infinite.
  static constexpr std::int32_t kNowhere = 0;

  // Returns the groups that are uncertain at this pose.
  const Column<std::int32_t>& PlaceWitnesses(const PosedPair& pair, std::size_t first_block,
                                             double near, Column<FeatureWitness>* witnesses) const;

  Column<Group> groups_;           // those disbanded have no place
  Column<std::int32_t> order_;     // of those that have one
  std::int32_t formed_ = 0;        // that many were formed together
  Column<std::int32_t> members_;   // candidates, group by group
  Column<std::int32_t> loners_;    // candidates without a group, in order
  Column<std::int32_t> place_;     // of each candidate
  Column<std::int32_t> group_at_;  // of each place; -1 for a block's fill
  Column<FeatureBlock> blocks_;
  Column<LaneRow> rows_;
};

}  // namespace contact_toolkit
