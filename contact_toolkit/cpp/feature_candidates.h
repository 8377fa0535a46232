// Candidate facet pairs by the features that carry their closest points. All facet pairs around the
// same two features share these points: they are placed once, and hold for all of them when the
// facets around are seen to leave nothing closer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "column.h"
#include "facet_pair.h"
#include "mesh.h"
#include "simd/kernels.h"

namespace contact_toolkit {

// Facet pairs in the order they were gathered in, with what was found there.
struct FacetCandidates {
  Column<std::int32_t> slot_a, slot_b;
  Column<double> distance;  // [m]
  Column<FeaturePair> features;

  std::size_t size() const { return slot_a.size(); }
};

// Immutable.
class FeatureCandidates {
 public:
  // All candidates on the same two features.
  struct Group {
    FeaturePair features;
    std::int32_t first;         // candidate
    std::int32_t count;         // of candidates
    std::int32_t first_member;  // index into members_
    std::int32_t place;         // where Measure leaves its witness, if it does
  };

  FeatureCandidates(const PosedPair& pair, const FacetCandidates& candidates);

  // By their first candidate.
  const Column<Group>& groups() const { return groups_; }

  // Where Measure leaves the witness of each candidate.
  const Column<std::int32_t>& place() const { return place_; }

  // Places the closest points of the groups that were `near` [m] where they were gathered. Where
  // they are too far or uncertain at this pose the distance is infinite. `alone` are, in order, the
  // near candidates to be measured one by one instead. Returns how many of them had certain
  // features where they were gathered.
  std::size_t Measure(const PosedPair& pair, const FacetCandidates& candidates, double near,
                      Column<FeatureWitness>* witnesses, Column<std::int32_t>* alone) const;

 private:
  struct Sides;
  class BlockWriter;

  std::span<const std::int32_t> Members(const Group& group) const {
    return {&members_[group.first_member], static_cast<std::size_t>(group.count)};
  }
  void FormGroups(const PosedPair& pair, const FacetCandidates& candidates);
  void PackGroups(const PosedPair& pair, const FacetCandidates& candidates);
  void DisbandUncertain(const PosedPair& pair);
  void PackBlock(std::span<Sides* const> lanes, const FacetCandidates& candidates);

  // Returns the groups that are uncertain at this pose.
  const Column<std::int32_t>& PlaceWitnesses(const PosedPair& pair, double near,
                                             Column<FeatureWitness>* witnesses) const;

  Column<Group> groups_;
  Column<std::int32_t> members_;   // candidates, group by group
  Column<std::int32_t> loners_;    // candidates without a group, in order
  Column<std::int32_t> place_;     // of each candidate
  Column<std::int32_t> group_at_;  // of each place; -1 for a block's fill
  Column<FeatureBlock> blocks_;
  Column<LaneRow> rows_;
};

}  // namespace contact_toolkit
