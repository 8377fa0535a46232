#include "feature_candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "feature_side.h"
#include "merge_table.h"
#include "tolerances.h"

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Blocks hold groups of one kind, taken from as many in a row: few enough for their witnesses to
// stay in the cache, and enough for the blocks to be full.
constexpr std::size_t kWindow = 512;

// The place of what has no witness: its distance is infinite.
constexpr std::int32_t kNowhere = 0;

}  // namespace

// A group's facets and features, to be packed.
struct FeatureCandidates::Sides {
  Group* group;
  FeatureSide a, b;
  double longest;  // [m] of all edges

  // A number to bring groups with the same features, and as many ways, together by.
  std::uint64_t Kind() const {
    return a.corners.size() << 48 | b.corners.size() << 32 | a.ways.size() << 16 | b.ways.size();
  }
  bool SameFeatures(const Sides& other) const {
    return a.corners.size() == other.a.corners.size() && b.corners.size() == other.b.corners.size();
  }
};

namespace {

// The features the kernel knows: a vertex and anything, or two edges.
bool CanTouchAtOnePoint(const FeaturePair& features) {
  const auto dimension = [](const Feature& f) { return static_cast<int>(f.kind); };
  return dimension(features.a) + dimension(features.b) <= 2;
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

FeatureCandidates::FeatureCandidates(const PosedPair& pair, const FacetCandidates& candidates) {
  group_at_ = {-1};
  FormGroups(pair, candidates);
  PackGroups(pair, candidates);
  DisbandUncertain(pair);
  std::sort(loners_.begin(), loners_.end());
}

void FeatureCandidates::FormGroups(const PosedPair& pair, const FacetCandidates& candidates) {
  const Bvh &a = pair.A.bvh(), &b = pair.B.bvh();
  const auto count = static_cast<std::int32_t>(candidates.size());
  place_.resize(count, kNowhere);
  thread_local MergeTable table;
  table.Clear();
  Column<std::int32_t> group(count, -1), filled;
  for (std::int32_t k = 0; k < count; ++k) {
    const FeaturePair& features = candidates.features[k];
    if (!CanTouchAtOnePoint(features) || a.slot_thin[candidates.slot_a[k]] ||
        b.slot_thin[candidates.slot_b[k]]) {
      loners_.push_back(k);
      continue;
    }
    std::int32_t* known = table.Find(features.key());
    if (*known < 0) {
      *known = static_cast<std::int32_t>(groups_.size());
      groups_.push_back({features, k, 0, 0, kNowhere});
    }
    group[k] = *known;
    ++groups_[*known].count;
  }
  std::int32_t begin = 0;
  for (Group& g : groups_) {
    g.first_member = begin;
    begin += g.count;
  }
  members_.resize(begin);
  filled.resize(groups_.size(), 0);
  for (std::int32_t k = 0; k < count; ++k) {
    if (group[k] >= 0) members_[groups_[group[k]].first_member + filled[group[k]]++] = k;
  }
}

void FeatureCandidates::PackGroups(const PosedPair& pair, const FacetCandidates& candidates) {
  thread_local std::vector<Sides> sides;
  sides.resize(std::max(sides.size(), std::min(kWindow, groups_.size())));
  std::vector<std::pair<std::uint64_t, Sides*>> order;
  std::vector<Sides*> lanes;
  for (std::size_t begin = 0; begin < groups_.size(); begin += kWindow) {
    order.clear();
    const std::size_t count = std::min(kWindow, groups_.size() - begin);
    for (std::size_t g = 0; g < count; ++g) {
      Sides& s = sides[g];
      s.group = &groups_[begin + g];
      s.a.Start(pair.A, s.group->features.a);
      s.b.Start(pair.B, s.group->features.b);
      for (std::int32_t member : Members(*s.group)) {
        s.a.AddFacet(candidates.slot_a[member]);
        s.b.AddFacet(candidates.slot_b[member]);
      }
      s.longest = std::sqrt(std::max(s.a.squared_longest, s.b.squared_longest));
      if (s.longest > kTinyFacet * pair.size) {
        order.emplace_back(s.Kind(), &s);
      } else {
        const auto members = Members(*s.group);
        loners_.insert(loners_.end(), members.begin(), members.end());
      }
    }
    std::sort(order.begin(), order.end());
    for (const auto& [kind, s] : order) {
      if (lanes.size() == kBvhWidth || (!lanes.empty() && !s->SameFeatures(*lanes[0]))) {
        PackBlock(lanes, candidates);
        lanes.clear();
      }
      lanes.push_back(s);
    }
    if (!lanes.empty()) PackBlock(lanes, candidates);
    lanes.clear();
  }
}

void FeatureCandidates::PackBlock(std::span<Sides* const> lanes,
                                  const FacetCandidates& candidates) {
  FeatureBlock block{};
  block.first_row = static_cast<std::int64_t>(rows_.size());
  block.nearest = kInfinity;
  block.corners_a = static_cast<std::int32_t>(lanes[0]->a.corners.size());
  block.corners_b = static_cast<std::int32_t>(lanes[0]->b.corners.size());
  for (const Sides* s : lanes) {
    block.ways_a = std::max(block.ways_a, static_cast<std::int32_t>(s->a.ways.size()));
    block.ways_b = std::max(block.ways_b, static_cast<std::int32_t>(s->b.ways.size()));
    block.nearest = std::min(block.nearest, candidates.distance[s->group->first]);
  }
  BlockWriter writer(&rows_, block);
  for (std::size_t lane = 0; lane < kBvhWidth; ++lane) {
    writer.Write(static_cast<int>(lane), *lanes[std::min(lane, lanes.size() - 1)]);
    const auto place = static_cast<std::int32_t>(group_at_.size());
    group_at_.push_back(-1);
    if (lane >= lanes.size()) continue;
    Group& group = *lanes[lane]->group;
    group_at_.back() = static_cast<std::int32_t>(&group - groups_.data());
    group.place = place;
    for (std::int32_t member : Members(group)) place_[member] = place;
  }
  blocks_.push_back(block);
}

void FeatureCandidates::DisbandUncertain(const PosedPair& pair) {
  thread_local Column<FeatureWitness> witnesses;
  for (std::int32_t uncertain : PlaceWitnesses(pair, kInfinity, &witnesses)) {
    Group& group = groups_[uncertain];
    for (std::int32_t member : Members(group)) {
      loners_.push_back(member);
      place_[member] = kNowhere;
    }
    group_at_[group.place] = -1;
    group.place = kNowhere;
  }
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
  const auto loners = static_cast<std::ptrdiff_t>(alone->size());
  for (std::int32_t group : PlaceWitnesses(pair, near, witnesses)) {
    keep_near(Members(groups_[group]));
  }
  std::sort(alone->begin() + loners, alone->end());
  std::inplace_merge(alone->begin(), alone->begin() + loners, alone->end());
  return alone->size() - loners;
}

const Column<std::int32_t>& FeatureCandidates::PlaceWitnesses(
    const PosedPair& pair, double near, Column<FeatureWitness>* witnesses) const {
  thread_local Column<std::uint8_t> uncertain;
  thread_local Column<std::int32_t> groups;
  if (uncertain.size() < blocks_.size()) uncertain.resize(blocks_.size());
  if (witnesses->size() < group_at_.size()) witnesses->resize(group_at_.size());
  pair.kernels.feature_distances(rows_.data(), blocks_.data(), blocks_.size(), pair.matrix, near,
                                 kTouching * pair.size, witnesses->data() + 1, uncertain.data());
  (*witnesses)[kNowhere].distance = kInfinity;
  groups.clear();
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    for (unsigned bits = uncertain[i]; bits != 0; bits &= bits - 1) {
      const std::size_t place = 1 + kBvhWidth * i + __builtin_ctz(bits);
      (*witnesses)[place].distance = kInfinity;
      if (group_at_[place] >= 0) groups.push_back(group_at_[place]);
    }
  }
  return groups;
}

}  // namespace contact_toolkit
