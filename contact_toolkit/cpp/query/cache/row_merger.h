// The rows of a coherent query, in the order of its candidates: some from the witnesses of
// features, the others measured one by one.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/column.h"
#include "base/scratch.h"
#include "query/cache/feature_candidates.h"
#include "query/witness/facet_pair.h"
#include "query/witness/merge_table.h"
#include "query/witness/row_writer.h"
#include "query/witness/witness.h"

namespace contact_toolkit {

// Candidates measured one by one.
struct MeasuredRows {
  Column<std::int32_t> measured;   // candidates
  Column<FeaturePair> features;    // of each
  WitnessPairs rows;               // of those within the standoff
  Column<std::int32_t> candidate;  // of each row

  void Clear() {
    measured.clear();
    features.clear();
    rows.Resize(0);
    candidate.clear();
  }

  // Measures the candidates in `measured`.
  void Measure(const PosedPair& pair, const FacetCandidates& candidates, double standoff) {
    RowWriter write{pair, standoff, false, nullptr, &rows};
    auto& chunk = Scratch<FacetPairs>([] {});
    for (std::size_t begin = 0; begin < measured.size(); begin += chunk.count) {
      chunk.count =
          static_cast<int>(std::min<std::size_t>(FacetPairs::kCapacity, measured.size() - begin));
      for (int k = 0; k < chunk.count; ++k) {
        chunk.slot_a[k] = candidates.slot_a[measured[begin + k]];
        chunk.slot_b[k] = candidates.slot_b[measured[begin + k]];
      }
      MeasureFacetPairs(pair, &chunk);
      std::size_t row = rows.size();
      write(chunk);
      for (int k = 0; k < chunk.count; ++k) {
        if (chunk.distance[k] > standoff) {
          features.push_back(FeaturesOf(pair, chunk, k));
          continue;
        }
        features.push_back({rows.feature_a[row], rows.feature_b[row]});
        candidate.push_back(measured[begin + k]);
        ++row;
      }
    }
  }
};

// Rows from witnesses of features and rows measured one by one, in the order of the candidates.
class RowMerger {
 public:
  RowMerger(const PosedPair& pair, const FacetCandidates& candidates,
            const FeatureCandidates& features, const Column<FeatureWitness>& witnesses,
            const MeasuredRows& measured, double standoff, WitnessPairs* rows)
      : slot_facet_a_(pair.A.bvh().slot_facet),
        slot_facet_b_(pair.B.bvh().slot_facet),
        candidates_(candidates),
        features_(features),
        witnesses_(witnesses),
        measured_(measured),
        standoff_(standoff),
        rows_(*rows) {}

  void WriteSingle() {
    const auto count = static_cast<std::int32_t>(candidates_.size());
    rows_.Resize(count);
    const std::int32_t* place = features_.place().data();
    const FeatureWitness* witnesses = witnesses_.data();
    const FeaturePair* features = candidates_.features.data();
    const double standoff = standoff_;
    const RowTarget to(&rows_);
    std::int32_t k = 0, next = 0;
    const auto write_until = [&](std::int32_t end) {
      for (; k < end; ++k) {
        Prefetch(&witnesses[place[std::min(k + kAhead, count - 1)]]);
        const FeatureWitness& w = witnesses[place[k]];
        if (w.distance <= standoff) Write(to, next++, w, Facets(k), features[k], 1);
      }
    };
    for (std::size_t i = 0; i < measured_.rows.size(); ++i) {
      write_until(measured_.candidate[i]);
      Copy(to, i, next++);
    }
    write_until(count);
    rows_.Resize(next);
  }

  void WriteMerged() {
    const std::size_t alone = measured_.rows.size();
    rows_.Resize(alone + features_.order().size());
    auto& table = Scratch<MergeTable>([] {});
    table.Clear();
    const RowTarget to(&rows_);
    std::int32_t next = 0;
    for (std::size_t i = 0; i < alone; ++i) table.Find(KeyOf(i));
    for (std::int32_t g : features_.order()) {
      if (features_.MayHaveTwin(g)) table.Find(features_.group(g).features.key());
    }
    std::size_t i = 0;
    const auto copy_until = [&](std::int32_t end) {
      for (; i < alone && measured_.candidate[i] < end; ++i) {
        std::int32_t* row = table.Find(KeyOf(i));
        if (*row >= 0) {
          ++rows_.multiplicity[*row];
        } else {
          *row = next;
          Copy(to, i, next++);
        }
      }
    };
    for (std::int32_t g : features_.order()) {
      const FeatureCandidates::Group& group = features_.group(g);
      const FeatureWitness& w = witnesses_[group.place];
      if (!(w.distance <= standoff_)) continue;
      copy_until(group.first);
      std::int32_t* row = table.Known(group.features.key());
      if (row != nullptr && *row >= 0) {
        rows_.multiplicity[*row] += group.count;
        continue;
      }
      if (row != nullptr) *row = next;
      Write(to, next++, w, Facets(group.first), group.features, group.count);
    }
    copy_until(static_cast<std::int32_t>(candidates_.size()));
    rows_.Resize(next);
  }

 private:
  // How many candidates ahead witnesses are fetched: they lie as their features had them packed.
  static constexpr std::int32_t kAhead = 12;
  static void Prefetch(const FeatureWitness* w) {
    __builtin_prefetch(&w->p_ACa);
    __builtin_prefetch(&w->distance);
  }

  static void Write(const RowTarget<WitnessPairs>& to, std::int32_t row, const FeatureWitness& w,
                    std::array<std::int32_t, 2> facets, const FeaturePair& features,
                    std::int32_t multiplicity) {
    to.Write(static_cast<std::size_t>(row), w.distance, w.p_ACa, w.p_ACb, w.normal_A, facets[0],
             facets[1], features.a, features.b, multiplicity);
  }

  std::array<std::int32_t, 2> Facets(std::int32_t candidate) const {
    return {slot_facet_a_[candidates_.slot_a[candidate]],
            slot_facet_b_[candidates_.slot_b[candidate]]};
  }

  std::uint64_t KeyOf(std::size_t i) const {
    return FeaturePair{measured_.rows.feature_a[i], measured_.rows.feature_b[i]}.key();
  }

  void Copy(const RowTarget<WitnessPairs>& to, std::size_t i, std::int32_t row) const {
    const WitnessPairs& from = measured_.rows;
    to.Write(static_cast<std::size_t>(row), from.distance[i], from.p_ACa[i], from.p_ACb[i],
             from.normal_A[i], from.facet_a[i], from.facet_b[i], from.feature_a[i],
             from.feature_b[i], from.multiplicity[i]);
  }

  const std::vector<std::int32_t>&slot_facet_a_, &slot_facet_b_;
  const FacetCandidates& candidates_;
  const FeatureCandidates& features_;
  const Column<FeatureWitness>& witnesses_;
  const MeasuredRows& measured_;
  const double standoff_;
  WitnessPairs& rows_;
};

}  // namespace contact_toolkit
