// The descent through two hierarchies to the facet pairs within reach of each other.
#pragma once

#include <cstdint>

#include "query/witness/facet_pair.h"

namespace contact_toolkit {

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
      bits = pair_.kernels.cull_by_axes(A.blocks[a.block], B.blocks[b.block], pair_.cull, reach_,
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

}  // namespace contact_toolkit
