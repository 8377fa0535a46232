// From measured facet pairs to the rows of a result.
#pragma once

#include <cstdint>

#include "query/witness/facet_pair.h"
#include "query/witness/merge_table.h"
#include "query/witness/witness.h"

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
      if (row != nullptr) *row = next;
      if (Touch(pair, chunk, k)) {
        const Witness w = WitnessOf(pair, chunk, k);
        Write(next, w.distance, w.p_ACa, w.p_ACb, w.normal_A);
      } else {
        Write(next, chunk.distance[k], At(chunk.point_a, k), At(chunk.point_b, k),
              At(chunk.normal, k));
      }
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

 private:
  // From the chunk straight to the columns: a Witness in between would have to be stored number by
  // number and read again in pairs, which the processor waits for.
  void Write(std::int32_t row, double distance, Vec3 p_ACa, Vec3 p_ACb, Vec3 normal_A) const {
    rows->distance[row] = distance;
    rows->p_ACa[row] = p_ACa;
    rows->p_ACb[row] = p_ACb;
    rows->normal_A[row] = normal_A;
  }
};

}  // namespace contact_toolkit
