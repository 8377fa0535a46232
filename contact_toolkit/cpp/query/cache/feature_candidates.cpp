#include "query/cache/feature_candidates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "base/scratch.h"
#include "base/tolerances.h"
#include "query/cache/feature_side.h"
#include "query/witness/merge_table.h"

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

// A group's facets and features, to be packed.
struct FeatureCandidates::Sides {
  Group* group;
  FeatureSide a, b;
  double longest;  // [m] of all edges

  bool SameFeatures(const Group& other) const {
    return group->features.a.kind == other.features.a.kind &&
           group->features.b.kind == other.features.b.kind;
  }
};

namespace {

// The features the kernel knows: a vertex and anything, or two edges.
bool CanTouchAtOnePoint(const FeaturePair& features) {
  const auto dimension = [](const Feature& f) { return static_cast<int>(f.kind); };
  return dimension(features.a) + dimension(features.b) <= 2;
}

// As std::inplace_merge, but with a buffer that stays.
template <class Less>
void MergeHalves(Column<std::int32_t>* values, std::ptrdiff_t middle, Less less) {
  auto& merged = Scratch<Column<std::int32_t>>([] {});
  merged.resize(values->size());
  const auto begin = values->begin(), half = begin + middle;
  std::merge(begin, half, half, values->end(), merged.begin(), less);
  std::copy(merged.begin(), merged.end(), begin);
}

// Sorts numbers below `limit`, no two of them equal: a bit is set for each, and bits lie in order.
void SortBelow(std::size_t limit, Column<std::int32_t>* values) {
  auto& words = Scratch<std::vector<std::uint64_t>>([] {});  // zero between calls
  words.resize(std::max(words.size(), limit / 64 + 1));
  for (std::int32_t v : *values) words[v / 64] |= std::uint64_t{1} << (v % 64);
  auto next = values->begin();
  for (std::size_t w = 0; next != values->end(); ++w) {
    for (std::uint64_t bits = std::exchange(words[w], 0); bits != 0; bits &= bits - 1) {
      *next++ = static_cast<std::int32_t>(64 * w + __builtin_ctzll(bits));
    }
  }
}

}  // namespace

// Writes the lanes of a block one after the other.
class FeatureCandidates::BlockWriter {
 public:
  BlockWriter(Column<LaneRow>* rows, const FeatureBlock& block) : rows_(*rows), block_(block) {
    const int ways = block.ways_a + block.ways_b;
    rows_.resize(rows_.size() + 3 * (block.corners_a + block.corners_b) + 1 + (3 * ways + 1) / 2);
  }

  void Write(int lane, const Sides& sides) {
    std::size_t row = block_.first_row;
    const auto put = [&](double x) { rows_[row++].lane[lane] = x; };
    for (const FeatureSide* side : {&sides.a, &sides.b}) {
      for (const Vec3& p : side->corners) put(p.x), put(p.y), put(p.z);
    }
    put(sides.longest);
    auto* halves = reinterpret_cast<float*>(&rows_[row]) + lane;
    const auto put_ways = [&](const std::vector<Vec3>& ways, int count, double unit) {
      for (int k = 0; k < count; ++k) {
        const Vec3& way = ways[k % ways.size()];
        for (int i = 0; i < 3; ++i, halves += kBvhWidth)
          *halves = static_cast<float>(way[i] / unit);
      }
    };
    put_ways(sides.a.ways, block_.ways_a, sides.longest);
    put_ways(sides.b.ways, block_.ways_b, -sides.longest);
  }

 private:
  Column<LaneRow>& rows_;
  const FeatureBlock& block_;
};

FeatureCandidates::FeatureCandidates(const PosedPair& pair, const FacetCandidates& candidates)
    : place_(candidates.size(), kNowhere), group_at_(1, -1) {
  Column<std::int32_t> all(candidates.size());
  std::iota(all.begin(), all.end(), 0);
  Regroup(pair, candidates, all);
  formed_ = static_cast<std::int32_t>(groups_.size());
}

void FeatureCandidates::Regroup(const PosedPair& pair, const FacetCandidates& candidates,
                                std::span<const std::int32_t> changed) {
  auto& again = Scratch<Column<std::int32_t>>([] {});
  auto& rest = Scratch<Column<std::int32_t>>([] {});
  again.clear(), rest.clear();
  for (std::int32_t k : changed) {
    if (place_[k] != kNowhere) Disband(group_at_[place_[k]], &again);
  }
  SortBelow(candidates.size(), &again);
  std::ranges::set_difference(loners_, changed, std::back_inserter(rest));
  std::swap(loners_, rest);
  rest.clear();
  std::ranges::set_union(again, changed, std::back_inserter(rest));
  const std::size_t first_group = groups_.size(), first_block = blocks_.size();
  FormGroups(pair, candidates, rest);
  PackGroups(pair, candidates, first_group);
  SortBelow(candidates.size(), &loners_);
  auto& witnesses = Scratch<Column<FeatureWitness>>([] {});
  for (std::int32_t uncertain : PlaceWitnesses(pair, first_block, kInfinity, &witnesses)) {
    groups_[uncertain].doubtful = true;
  }
  std::erase_if(order_, [this](std::int32_t g) { return groups_[g].place == kNowhere; });
  const auto ordered = static_cast<std::ptrdiff_t>(order_.size());
  for (std::size_t g = first_group; g < groups_.size(); ++g) {
    if (groups_[g].place != kNowhere) order_.push_back(static_cast<std::int32_t>(g));
  }
  MergeHalves(&order_, ordered, [this](std::int32_t g, std::int32_t h) {
    return groups_[g].first < groups_[h].first;
  });
}

std::size_t FeatureCandidates::Certain() const {
  std::size_t certain = 0;
  for (const std::int32_t g : order_) certain += groups_[g].doubtful ? 0 : groups_[g].count;
  return certain;
}

void FeatureCandidates::FormGroups(const PosedPair& pair, const FacetCandidates& candidates,
                                   std::span<const std::int32_t> members) {
  const Bvh &a = pair.A.bvh(), &b = pair.B.bvh();
  auto& table = Scratch<MergeTable>([] {});
  table.Clear();
  auto& group = Scratch<Column<std::int32_t>>([] {});
  auto& filled = Scratch<Column<std::int32_t>>([] {});
  group.assign(members.size(), -1);
  const std::size_t first_group = groups_.size();
  for (std::size_t i = 0; i < members.size(); ++i) {
    constexpr std::size_t kAhead = 8;
    table.Prefetch(candidates.features[members[std::min(i + kAhead, members.size() - 1)]].key());
    const std::int32_t k = members[i];
    const FeaturePair& features = candidates.features[k];
    if (!CanTouchAtOnePoint(features) || a.slot_thin[candidates.slot_a[k]] ||
        b.slot_thin[candidates.slot_b[k]]) {
      loners_.push_back(k);
      continue;
    }
    std::int32_t* known = table.Find(features.key());
    if (*known < 0) {
      *known = static_cast<std::int32_t>(groups_.size());
      groups_.push_back({features, k, 0, 0, kNowhere, false});
    }
    group[i] = *known;
    ++groups_[*known].count;
  }
  auto end = static_cast<std::int32_t>(members_.size());
  for (std::size_t g = first_group; g < groups_.size(); ++g) {
    groups_[g].first_member = end;
    end += groups_[g].count;
  }
  members_.resize(end);
  filled.assign(groups_.size() - first_group, 0);
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (group[i] < 0) continue;
    members_[groups_[group[i]].first_member + filled[group[i] - first_group]++] = members[i];
  }
}

void FeatureCandidates::PackGroups(const PosedPair& pair, const FacetCandidates& candidates,
                                   std::size_t first) {
  auto& lanes = Scratch<std::array<Sides, kBvhWidth>>([] {});
  std::size_t filled = 0;
  const auto pack = [&] {
    if (filled > 0) PackBlock({lanes.data(), filled}, candidates);
    filled = 0;
  };
  for (std::size_t begin = first; begin < groups_.size(); begin += kWindow) {
    const std::size_t end = std::min(begin + kWindow, groups_.size());
    for (Group* group : SortedByKind({groups_.data() + begin, end - begin})) {
      if (filled == lanes.size() || (filled > 0 && !lanes[0].SameFeatures(*group))) pack();
      Sides& s = lanes[filled];
      const auto members = Members(*group);
      s.group = group;
      s.a.Start(pair.A, group->features.a);
      s.b.Start(pair.B, group->features.b);
      for (const std::int32_t member : members) {
        s.a.AddFacet(candidates.slot_a[member]);
        s.b.AddFacet(candidates.slot_b[member]);
      }
      s.longest = std::sqrt(std::max(s.a.squared_longest, s.b.squared_longest));
      if (s.longest > kTinyFacet * pair.size) {
        ++filled;
      } else {
        loners_.insert(loners_.end(), members.begin(), members.end());
      }
    }
    pack();
  }
}

// The groups, at most kWindow, so that those that fill a block well are together: with the same
// kinds of features, and as many pairs, hence about as many ways.
std::span<FeatureCandidates::Group*> FeatureCandidates::SortedByKind(std::span<Group> groups) {
  static constexpr std::size_t kMostPairs = 16, kKinds = 9 * kMostPairs;
  const auto kind = [](const Group& group) {
    const auto dimension = [](const Feature& f) { return static_cast<std::size_t>(f.kind); };
    return (dimension(group.features.a) * 3 + dimension(group.features.b)) * kMostPairs +
           std::min<std::size_t>(group.count, kMostPairs) - 1;
  };
  std::array<std::uint16_t, kKinds + 1> place{};  // where the next of each kind belongs
  for (const Group& group : groups) ++place[kind(group) + 1];
  for (std::size_t k = 1; k <= kKinds; ++k) place[k] += place[k - 1];
  auto& sorted = Scratch<std::array<Group*, kWindow>>([] {});
  for (Group& group : groups) sorted[place[kind(group)]++] = &group;
  return {sorted.data(), groups.size()};
}

void FeatureCandidates::PackBlock(std::span<const Sides> lanes, const FacetCandidates& candidates) {
  FeatureBlock block{};
  block.first_row = static_cast<std::int64_t>(rows_.size());
  block.nearest = kInfinity;
  block.corners_a = static_cast<std::int32_t>(lanes[0].a.corners.size());
  block.corners_b = static_cast<std::int32_t>(lanes[0].b.corners.size());
  for (const Sides& s : lanes) {
    block.ways_a = std::max(block.ways_a, static_cast<std::int32_t>(s.a.ways.size()));
    block.ways_b = std::max(block.ways_b, static_cast<std::int32_t>(s.b.ways.size()));
    for (std::int32_t member : Members(*s.group)) {
      block.nearest = std::min(block.nearest, candidates.distance[member]);
    }
  }
  BlockWriter writer(&rows_, block);
  for (std::size_t lane = 0; lane < kBvhWidth; ++lane) {
    writer.Write(static_cast<int>(lane), lanes[std::min(lane, lanes.size() - 1)]);
    const auto place = static_cast<std::int32_t>(group_at_.size());
    group_at_.push_back(-1);
    if (lane >= lanes.size()) continue;
    Group& group = *lanes[lane].group;
    group_at_.back() = static_cast<std::int32_t>(&group - groups_.data());
    group.place = place;
    for (std::int32_t member : Members(group)) place_[member] = place;
  }
  blocks_.push_back(block);
}

void FeatureCandidates::Disband(std::int32_t index, Column<std::int32_t>* members) {
  Group& group = groups_[index];
  for (std::int32_t member : Members(group)) {
    members->push_back(member);
    place_[member] = kNowhere;
  }
  group_at_[group.place] = -1;
  const std::int32_t block = (group.place - 1) / kBvhWidth;
  const auto first = group_at_.begin() + 1 + kBvhWidth * block;
  if (std::all_of(first, first + kBvhWidth, [](std::int32_t g) { return g < 0; })) {
    blocks_[block].nearest = kInfinity;
  }
  group.place = kNowhere;
}

std::size_t FeatureCandidates::Measure(const PosedPair& pair, const FacetCandidates& candidates,
                                       double near, Column<FeatureWitness>* witnesses,
                                       Column<std::int32_t>* alone) const {
  alone->clear();
  const auto keep_near = [&](std::span<const std::int32_t> members) {
    for (std::int32_t k : members) {
      if (candidates.distance[k] <= near) alone->push_back(k);
    }
  };
  keep_near(loners_);
  std::size_t changed = 0;
  for (std::int32_t group : PlaceWitnesses(pair, 0, near, witnesses)) {
    const std::size_t before = alone->size();
    keep_near(Members(groups_[group]));
    if (!groups_[group].doubtful) changed += alone->size() - before;
  }
  SortBelow(candidates.size(), alone);
  return changed;
}

const Column<std::int32_t>& FeatureCandidates::PlaceWitnesses(
    const PosedPair& pair, std::size_t first_block, double near,
    Column<FeatureWitness>* witnesses) const {
  auto& uncertain = Scratch<Column<std::uint8_t>>([] {});
  auto& groups = Scratch<Column<std::int32_t>>([] {});
  if (uncertain.size() < blocks_.size()) uncertain.resize(blocks_.size());
  if (witnesses->size() < group_at_.size()) witnesses->resize(group_at_.size());
  pair.kernels.feature_distances(
      rows_.data(), blocks_.data() + first_block, blocks_.size() - first_block, pair.matrix, near,
      kTouching * pair.size, witnesses->data() + 1 + kBvhWidth * first_block,
      uncertain.data() + first_block);
  (*witnesses)[kNowhere].distance = kInfinity;
  groups.clear();
  for (std::size_t i = first_block; i < blocks_.size(); ++i) {
    for (unsigned bits = uncertain[i]; bits != 0; bits &= bits - 1) {
      const std::size_t place = 1 + kBvhWidth * i + __builtin_ctz(bits);
      (*witnesses)[place].distance = kInfinity;
      if (group_at_[place] >= 0) groups.push_back(group_at_[place]);
    }
  }
  return groups;
}

}  // namespace contact_toolkit
