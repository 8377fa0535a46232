// From measured facet pairs to the rows of a result.
#pragma once

#include <cstdint>

#include "facet_pair.h"
#include "merge_table.h"
#include "witness.h"

namespace contact_toolkit {

// Turns measured chunks into rows.
struct RowWriter {
  const PosedPair& pair;
  double standoff;
  bool merge;
  MergeTable* table;
  WitnessPairs* rows;

  bool operator()(const FacetPairs& chunk) {
    auto next = static_cast<std::int32_t>(rows->size());
    rows->Resize(next + chunk.count);
    for (int k = 0; k < chunk.count; ++k) {
      if (chunk.distance[k] > standoff) continue;
      const FeaturePair features = FeaturesOf(pair, chunk, k);
      std::int32_t* row = merge ? table->Find(features.key()) : nullptr;
      if (row != nullptr && *row >= 0) {
        ++rows->multiplicity[*row];
        continue;
      }
      const Witness w = WitnessOf(pair, chunk, k);
      if (row != nullptr) *row = next;
      rows->distance[next] = w.distance;
      rows->p_ACa[next] = w.p_ACa;
      rows->p_ACb[next] = w.p_ACb;
      rows->normal_A[next] = w.normal_A;
      rows->facet_a[next] = pair.A.bvh().slot_facet[chunk.slot_a[k]];
      rows->facet_b[next] = pair.B.bvh().slot_facet[chunk.slot_b[k]];
      rows->feature_a[next] = features.a;
      rows->feature_b[next] = features.b;
      rows->multiplicity[next] = 1;
      ++next;
    }
    rows->Resize(next);
    return true;
  }
};

}  // namespace contact_toolkit
