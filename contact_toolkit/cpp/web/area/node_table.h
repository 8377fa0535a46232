// What is found out about the candidates' nodes in one look at a pose. Only few of many nodes are
// touched, so only those are put back.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "math/vec.h"
#include "web/area/probed_surface.h"

namespace contact_toolkit {

class NodeTable {
 public:
  static constexpr double kUnknown = -std::numeric_limits<double>::infinity();

  struct State {
    double deformation = kUnknown;  // unless probed
    double share = 0;    // [m²] the mean of what falls to it as its loaded triangles see it
    int num_loaded = 0;  // of the triangles that meet here
    bool placed = false, tried = false;
  };
  // What a node bears: one for what its triangles meet by its own value and one flat side, more for
  // further sides.
  struct Load {
    double integral = 0;
    double raised = 0;        // [m³] the part of its moment that is due to bulges
    int num_facing = 0;       // of those, which face this side more than any other
    std::int32_t side = -1;   // beneath a flat triangle that meets here
    std::int32_t ground = 0;  // of that triangle
    std::int32_t next = -1;   // another one of the node
  };
  struct Probed {
    Vec3 p;  // in the probed body
    FieldValue field;
  };

  std::vector<State> state;
  std::vector<Load> loads;  // the first of each node, then further ones
  std::vector<Probed> probed;

  // For so many nodes, of which nothing is known.
  void Begin(std::size_t count) {
    ForEachTouched([this](std::int32_t i) {
      state[i] = {};
      loads[i] = {};
    });
    loads.resize(num_nodes_);  // without the further ones
    loads.resize(count);
    if (state.size() < count) state.resize(count);
    if (probed.size() < count) probed.resize(count);
    touched_.assign(count / kWordBits + 1, 0);
    num_nodes_ = count;
  }

  // Before anything is said of a node.
  void Touch(std::int32_t i) { touched_[i / kWordBits] |= 1ull << i % kWordBits; }

  // Calls act(i) for each touched node, in order.
  template <typename Act>
  void ForEachTouched(const Act& act) const {
    for (std::size_t word = 0; word < touched_.size(); ++word) {
      for (std::uint64_t rest = touched_[word]; rest != 0; rest &= rest - 1) {
        act(static_cast<std::int32_t>(kWordBits * word + std::countr_zero(rest)));
      }
    }
  }

  // The load of node i above a side.
  std::int32_t LoadOf(std::int32_t i, std::int32_t side, std::int32_t ground) {
    while (loads[i].side >= 0 && loads[i].side != side) {
      if (loads[i].next < 0) {
        loads[i].next = static_cast<std::int32_t>(loads.size());
        loads.emplace_back();
      }
      i = loads[i].next;
    }
    loads[i].side = side;
    loads[i].ground = ground;
    return i;
  }

  // Of a node's loads, that which most of its triangles face.
  std::int32_t FacedBy(std::int32_t i) const {
    std::int32_t first = i;
    for (std::int32_t load = i; load >= 0; load = loads[load].next) {
      const Load &best = loads[first], &other = loads[load];
      if (other.num_facing > best.num_facing ||
          (other.num_facing == best.num_facing && other.side < best.side)) {
        first = load;
      }
    }
    return first;
  }

 private:
  static constexpr int kWordBits = 64;

  std::vector<std::uint64_t> touched_;  // a bit a node
  std::size_t num_nodes_ = 0;
};

}  // namespace contact_toolkit
