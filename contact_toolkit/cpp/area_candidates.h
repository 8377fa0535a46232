// The nodes of a sampled surface that may bear load, and the triangles between them: at one pose,
// or at all poses near one, which is worth remembering.
#pragma once

#include <cstdint>
#include <vector>

#include "area_nodes.h"
#include "rounded_down.h"
#include "scratch.h"
#include "vec.h"

namespace contact_toolkit {

struct AreaCandidates {
  struct Node {
    Vec3 p;              // in the sampled body
    double weight;       // [m²] see AreaPatch
    std::int32_t index;  // in its patch
    float clearance;     // [m] until it has moved so far it certainly bears no load; if negative
                         // it may bear some, but is certainly no deeper
  };
  struct Part {  // of a patch; its nodes and triangles follow those of the part before
    std::int32_t patch, last_node, last_triangle;
  };
  std::vector<Part> parts;
  std::vector<Node> nodes;                     // of each patch in its order
  std::vector<AreaPatch::Triangle> triangles;  // likewise; of indices into `nodes`

  void Clear() {
    parts.clear();
    nodes.clear();
    triangles.clear();
  }
};

// Gathers the triangles that may have a loaded corner. `near(sphere)`: whether loaded nodes may lie
// in the sphere; `clearance(p)`: of a node at p. What they are asked is in the sampled body's
// frame.
template <typename Near, typename Clearance>
void GatherCandidates(const AreaNodes& sampled, const Near& near, const Clearance& clearance,
                      AreaCandidates* candidates) {
  constexpr std::int32_t kUnseen = -1, kSeen = 0;
  auto& place_of = Scratch<std::vector<std::int32_t>>([] {});  // in `nodes`, of each of the patch's
  auto& leaves = Scratch<std::vector<std::int32_t>>([] {});
  auto& [parts, nodes, triangles] = *candidates;
  candidates->Clear();
  sampled.tree().ForEach(near, [&](std::int32_t index) {
    const AreaPatch& patch = sampled.patch(index);
    const auto count = static_cast<std::int32_t>(patch.nodes.size());
    place_of.assign(patch.nodes.size(), kUnseen);
    leaves.clear();
    patch.tree.ForEach(near, [&](std::int32_t leaf) {
      leaves.push_back(leaf);
      for (std::int32_t i = patch.leaves[leaf].first; i < patch.leaves[leaf].last; ++i) {
        for (const std::int32_t node : patch.triangles[i].node) place_of[node] = kSeen;
      }
    });
    if (leaves.empty()) return;
    for (std::int32_t i = 0; i < count; ++i) {
      if (place_of[i] == kUnseen) continue;
      place_of[i] = static_cast<std::int32_t>(nodes.size());
      const Vec3& p = patch.nodes[i];
      nodes.push_back({p, patch.weight[i], i, RoundedDown(clearance(p))});
    }
    for (const std::int32_t leaf : leaves) {
      for (std::int32_t i = patch.leaves[leaf].first; i < patch.leaves[leaf].last; ++i) {
        AreaPatch::Triangle triangle = patch.triangles[i];
        bool spared = true;
        for (std::int32_t& node : triangle.node) {
          node = place_of[node];
          spared = spared && nodes[node].clearance > 0;
        }
        if (!spared) triangles.push_back(triangle);
      }
    }
    parts.push_back({index, static_cast<std::int32_t>(nodes.size()),
                     static_cast<std::int32_t>(triangles.size())});
  });
}

}  // namespace contact_toolkit
