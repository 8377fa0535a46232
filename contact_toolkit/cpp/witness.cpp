#include "witness.h"

#include "facet_pair.h"
#include "merge_table.h"
#include "parallel.h"
#include "row_writer.h"
#include "scratch.h"
#include "tolerances.h"
#include "traversal.h"

namespace contact_toolkit {
namespace {

// Splits the traversal into node pairs whose results, one after the other, are those of the whole.
std::vector<NodePair> Split(const PosedPair& pair, double reach, std::size_t enough) {
  std::vector<NodePair> tasks{{0, 0}};
  for (bool grew = true; grew && tasks.size() < enough;) {
    grew = false;
    std::vector<NodePair> finer;
    for (const NodePair& task : tasks) {
      const BvhNode &a = pair.A.bvh().nodes[task.a], &b = pair.B.bvh().nodes[task.b];
      if (a.bottom() && b.bottom()) {
        finer.push_back(task);
        continue;
      }
      grew = true;
      const std::uint64_t bits = pair.kernels.box_pairs(a, b, pair.cull, static_cast<float>(reach));
      Traversal<RowWriter>::ForChildren(a, b, task, bits,
                                        [&](NodePair child) { finer.push_back(child); });
    }
    tasks = std::move(finer);
  }
  return tasks;
}

template <class T>
void Append(const Column<T>& from, Column<T>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

// Appends rows found apart, merging those whose features the earlier ones already have.
void AppendRows(const WitnessPairs& from, bool merge, MergeTable* table, WitnessPairs* to) {
  if (!merge) {
    Append(from.distance, &to->distance);
    Append(from.p_ACa, &to->p_ACa);
    Append(from.p_ACb, &to->p_ACb);
    Append(from.normal_A, &to->normal_A);
    Append(from.facet_a, &to->facet_a);
    Append(from.facet_b, &to->facet_b);
    Append(from.feature_a, &to->feature_a);
    Append(from.feature_b, &to->feature_b);
    Append(from.multiplicity, &to->multiplicity);
    return;
  }
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::int32_t* row = table->Find(FeaturePair{from.feature_a[i], from.feature_b[i]}.key());
    if (*row >= 0) {
      to->multiplicity[*row] += from.multiplicity[i];
      continue;
    }
    *row = static_cast<std::int32_t>(to->size());
    to->distance.push_back(from.distance[i]);
    to->p_ACa.push_back(from.p_ACa[i]);
    to->p_ACb.push_back(from.p_ACb[i]);
    to->normal_A.push_back(from.normal_A[i]);
    to->facet_a.push_back(from.facet_a[i]);
    to->facet_b.push_back(from.facet_b[i]);
    to->feature_a.push_back(from.feature_a[i]);
    to->feature_b.push_back(from.feature_b[i]);
    to->multiplicity.push_back(from.multiplicity[i]);
  }
}

void FindInParallel(const PosedPair& pair, double standoff, const WitnessOptions& options,
                    WitnessPairs* pairs) {
  const std::vector<NodePair> tasks = Split(pair, standoff, 16 * options.threads);
  std::vector<WitnessPairs> found(tasks.size());
  ParallelFor(static_cast<int>(tasks.size()), options.threads, [&](int i, int) {
    auto& table = Scratch<MergeTable>([] {});
    table.Clear();
    RowWriter writer{pair, standoff, options.merge, &table, &found[i]};
    Traversal(pair, standoff, &writer).Run(tasks[i]);
  });
  auto& table = Scratch<MergeTable>([] {});
  table.Clear();
  for (const WitnessPairs& part : found) AppendRows(part, options.merge, &table, pairs);
}

}  // namespace

void WitnessPairs::Resize(std::size_t rows) {
  distance.resize(rows);
  p_ACa.resize(rows);
  p_ACb.resize(rows);
  normal_A.resize(rows);
  facet_a.resize(rows);
  facet_b.resize(rows);
  feature_a.resize(rows);
  feature_b.resize(rows);
  multiplicity.resize(rows);
}

void WitnessPairs::Reserve(std::size_t rows) {
  distance.reserve(rows);
  p_ACa.reserve(rows);
  p_ACb.reserve(rows);
  normal_A.reserve(rows);
  facet_a.reserve(rows);
  facet_b.reserve(rows);
  feature_a.reserve(rows);
  feature_b.reserve(rows);
  multiplicity.reserve(rows);
}

void FindWitnessPairs(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                      double standoff, const WitnessOptions& options, WitnessPairs* pairs) {
  pairs->Resize(0);
  const PosedPair pair(A, B, X_AB);
  if (options.threads > 1) {
    FindInParallel(pair, standoff, options, pairs);
    return;
  }
  auto& table = Scratch<MergeTable>([] {});
  table.Clear();
  RowWriter writer{pair, standoff, options.merge, &table, pairs};
  Traversal(pair, standoff, &writer).Run({0, 0});
}

bool Intersects(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB) {
  const PosedPair pair(A, B, X_AB);
  bool touching = false;
  const double most = kTouching * pair.size;
  auto stop_at_touch = [&](const FacetPairs& chunk) {
    for (int k = 0; k < chunk.count; ++k) {
      touching = touching || chunk.distance[k] <= most;
    }
    return !touching;
  };
  Traversal(pair, most, &stop_at_touch).Run({0, 0});
  return touching;
}

}  // namespace contact_toolkit
