// The rows of a coherent query, in the order of its candidates: some from the witnesses of
// features, the others measured one by one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "column.h"
#include "facet_pair.h"
#include "feature_candidates.h"
#include "merge_table.h"
#include "row_writer.h"
#include "witness.h"

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
    thread_local FacetPairs chunk;
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
    rows_.Resize(candidates_.size());
    const Column<std::int32_t>& place = features_.place();
    std::int32_t k = 0;
    const auto write_until = [&](std::int32_t end) {
      for (; k < end; ++k) {
        const FeatureWitness& w = witnesses_[place[k]];
        if (w.distance <= standoff_) Write(w, k, candidates_.features[k], 1);
      }
    };
    for (std::size_t i = 0; i < measured_.rows.size(); ++i) {
      write_until(measured_.candidate[i]);
      Copy(i);
    }
    write_until(static_cast<std::int32_t>(candidates_.size()));
    rows_.Resize(next_);
  }

  void WriteMerged() {
    const std::size_t alone = measured_.rows.size();
    rows_.Resize(alone + features_.order().size());
    thread_local MergeTable table;
    table.Clear();
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
          *row = next_;
          Copy(i);
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
      if (row != nullptr) *row = next_;
      Write(w, group.first, group.features, group.count);
    }
    copy_until(static_cast<std::int32_t>(candidates_.size()));
    rows_.Resize(next_);
  }

 private:
  std::uint64_t KeyOf(std::size_t i) const {
    return FeaturePair{measured_.rows.feature_a[i], measured_.rows.feature_b[i]}.key();
  }

  void Write(const FeatureWitness& w, std::int32_t candidate, const FeaturePair& features,
             std::int32_t multiplicity) {
    rows_.distance[next_] = w.distance;
    rows_.p_ACa[next_] = w.p_ACa;
    rows_.p_ACb[next_] = w.p_ACb;
    rows_.normal_A[next_] = w.normal_A;
    rows_.facet_a[next_] = slot_facet_a_[candidates_.slot_a[candidate]];
    rows_.facet_b[next_] = slot_facet_b_[candidates_.slot_b[candidate]];
    rows_.feature_a[next_] = features.a;
    rows_.feature_b[next_] = features.b;
    rows_.multiplicity[next_] = multiplicity;
    ++next_;
  }

  void Copy(std::size_t i) {
    const WitnessPairs& from = measured_.rows;
    rows_.distance[next_] = from.distance[i];
    rows_.p_ACa[next_] = from.p_ACa[i];
    rows_.p_ACb[next_] = from.p_ACb[i];
    rows_.normal_A[next_] = from.normal_A[i];
    rows_.facet_a[next_] = from.facet_a[i];
    rows_.facet_b[next_] = from.facet_b[i];
    rows_.feature_a[next_] = from.feature_a[i];
    rows_.feature_b[next_] = from.feature_b[i];
    rows_.multiplicity[next_] = from.multiplicity[i];
    ++next_;
  }

  const std::vector<std::int32_t>&slot_facet_a_, &slot_facet_b_;
  const FacetCandidates& candidates_;
  const FeatureCandidates& features_;
  const Column<FeatureWitness>& witnesses_;
  const MeasuredRows& measured_;
  const double standoff_;
  WitnessPairs& rows_;
  std::int32_t next_ = 0;
};

}  // namespace contact_toolkit
