#include "query/witness/witness.h"

#include "base/parallel.h"
#include "base/scratch.h"
#include "query/witness/facet_pair.h"
#include "query/witness/merge_table.h"
#include "query/witness/row_writer.h"
#include "query/witness/traversal.h"

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

// Appends rows found apart, merging those whose features the earlier ones already have.
void AppendRows(const WitnessPairs& from, bool merge, MergeTable* table, WitnessPairs* to) {
  if (!merge) {
    AppendColumns(from, to);
    return;
  }
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::int32_t* row = table->Find(FeaturePair{from.feature_a[i], from.feature_b[i]}.key());
    if (*row >= 0) {
      to->multiplicity[*row] += from.multiplicity[i];
      continue;
    }
    *row = static_cast<std::int32_t>(to->size());
    AppendRow(from, i, to);
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

}  // namespace contact_toolkit
