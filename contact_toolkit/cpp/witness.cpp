#include "witness.h"

#include <algorithm>
#include <cmath>

#include "facet_pair.h"
#include "merge_table.h"
#include "parallel.h"
#include "tolerances.h"

namespace contact_toolkit {
namespace {

struct NodePair {
  std::int32_t a, b;
};

// Finds the facet pairs within reach, in a fixed order, and hands them on in measured chunks.
template <class Sink>
class Traversal {
 public:
  Traversal(const PosedPair& pair, double reach, Sink* sink)
      : pair_(pair), reach_(static_cast<float>(reach)), sink_(*sink) {}

  void Run(NodePair start) {
    Visit(start);
    Flush();
  }

 private:
  void Visit(NodePair pair) {
    if (stopped_) return;
    const Bvh &A = pair_.A.bvh(), &B = pair_.B.bvh();
    const BvhNode &a = A.nodes[pair.a], &b = B.nodes[pair.b];
    std::uint64_t bits = pair_.kernels.box_pairs(a, b, pair_.cull, reach_);
    if (bits == 0) return;
    if (a.bottom() && b.bottom()) {
      bits = pair_.kernels.cull_by_planes(A.blocks[a.block], B.blocks[b.block], pair_.cull, reach_,
                                          bits);
      for (; bits != 0; bits &= bits - 1) {
        const int bit = __builtin_ctzll(bits);
        Add(a.child[bit & 7], b.child[bit >> 3]);
      }
    } else {
      ForChildren(a, b, pair, bits, [this](NodePair child) { Visit(child); });
    }
  }

  void Add(std::int32_t slot_a, std::int32_t slot_b) {
    chunk_.slot_a[chunk_.count] = slot_a;
    chunk_.slot_b[chunk_.count] = slot_b;
    if (++chunk_.count == FacetPairs::kCapacity) Flush();
  }

  void Flush() {
    MeasureFacetPairs(pair_, &chunk_);
    if (!stopped_) stopped_ = !sink_(chunk_);
    chunk_.count = 0;
  }

  const PosedPair& pair_;
  const float reach_;
  Sink& sink_;
  FacetPairs chunk_;
  bool stopped_ = false;

 public:
  // Calls visit for the pairs of children whose bits are set; a bottom node stays while the other
  // side descends.
  template <class Visit>
  static void ForChildren(const BvhNode& a, const BvhNode& b, NodePair pair, std::uint64_t bits,
                          Visit visit) {
    for (int j = 0; j < b.count; ++j) {
      const std::uint64_t row = bits >> (8 * j) & 0xff;
      if (a.bottom()) {
        if (row != 0) visit(NodePair{pair.a, b.child[j]});
        continue;
      }
      if (b.bottom()) break;
      for (std::uint64_t rest = row; rest != 0; rest &= rest - 1) {
        visit(NodePair{a.child[__builtin_ctzll(rest)], b.child[j]});
      }
    }
    if (b.bottom()) {
      std::uint64_t column = bits;
      for (int shift = 32; shift >= 8; shift /= 2) column |= column >> shift;
      for (column &= 0xff; column != 0; column &= column - 1) {
        visit(NodePair{a.child[__builtin_ctzll(column)], pair.b});
      }
    }
  }
};

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
    thread_local MergeTable table;
    table.Clear();
    RowWriter writer{pair, standoff, options.merge, &table, &found[i]};
    Traversal(pair, standoff, &writer).Run(tasks[i]);
  });
  thread_local MergeTable table;
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

void FindWitnessPairs(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                      double standoff, const WitnessOptions& options, WitnessPairs* pairs) {
  pairs->Resize(0);
  const PosedPair pair(A, B, X_AB);
  if (options.threads > 1) {
    FindInParallel(pair, standoff, options, pairs);
    return;
  }
  thread_local MergeTable table;
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
