// The nodes of a sampled surface that may bear load, and the triangles between them: at one pose,
// or at all poses near one, which is worth remembering.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/scratch.h"
#include "math/rounded_down.h"
#include "math/vec.h"
#include "web/area/area_nodes.h"

namespace contact_toolkit {

struct AreaCandidates {
  static constexpr std::int32_t kSmallest = -1, kOpen = -2, kDeeper = -3, kOpenSmallest = -4;

  struct Node {
    Vec3 p;              // in the sampled body
    std::int32_t index;  // in its patch
    float clearance;     // [m] until it has moved so far it certainly bears no load; if negative
                         // it may bear some, but is certainly no deeper. Not a number where only
                         // flat triangles meet
  };
  struct Triangle {
    std::array<std::int32_t, 3> node;
    std::int32_t last;  // one past its parts
    // All of the probed body that it can meet, if it is flat there: see AreaGrounds::Under();
    // kSmallest: it has no parts; kOpen: whether it is flat depends on the pose, its parts follow;
    // kDeeper: its parts are a part of their own, heard only where this is; kOpenSmallest: both,
    // of a round surface, of which only the smallest may be taken for flat.
    std::int32_t ground;
    double area;                  // [m²]
    std::array<double, 3> share;  // [m²] of the surface, what falls to each corner
    std::int32_t deeper = -1;     // of kDeeper: that part's number
  };
  struct Part {  // of a patch; its nodes and triangles follow those of the part before
    std::int32_t patch, last_node, last_triangle;
    std::int32_t deeper = -1;  // its number; -1: heard in any case
  };
  std::vector<Part> parts;
  std::vector<Node> nodes;          // of each patch in its order
  std::vector<Triangle> triangles;  // likewise; of indices into `nodes`
  // [m] Of each triangle, the least of its corners; all are looked through, so they stand alone.
  // Minus infinity where parts follow: its ground tells the exact distance, where the field that
  // its nodes are probed in may be a smooth one.
  std::vector<float> clearances;

  std::int32_t num_deeper = 0;

  void Clear() {
    num_deeper = 0;
    parts.clear();
    nodes.clear();
    triangles.clear();
    clearances.clear();
  }
};

// Gathers the triangles that may have a loaded corner. What `Test` is asked is in the sampled
// body's frame:
//   MayLoad(sphere): whether loaded nodes may lie in the sphere;
//   MayLoad(corners): the same of a triangle;
//   Clearance(p): of a node at p;
//   GroundUnder(corners): see AreaCandidates::Triangle; -1 where it is not certain at all poses;
//   IsNeverFlat(corners): whether that is certain to stay so at all poses;
//   IsRound(corners): whether parts of a triangle do not lie in it;
//   ClearanceAnywhere(corners): of a triangle, whatever it meets;
//   Farthest(corners): how far they may yet move;
//   MayLoadAbove(leaf, &side): whether a patch's leaf may have loaded nodes, where that is the side
//     under all its triangles;
//   ClearanceAbove(ground, corners): of a triangle, where that is all it can meet;
//   at_one_pose: whether triangles that are not flat need not be asked again.
template <typename Test>
class CandidateGatherer {
 public:
  CandidateGatherer(const AreaNodes& sampled, const Test& test, AreaCandidates* candidates)
      : sampled_(sampled), test_(test), candidates_(*candidates) {}

  void Run() {
    candidates_.Clear();
    const auto near = [&](const Sphere& sphere) { return test_.MayLoad(sphere); };
    sampled_.tree().ForEach(near, [&](std::int32_t index) {
      patch_ = index;
      const AreaPatch& patch = sampled_.patch(index);
      std::size_t first_triangle = candidates_.triangles.size();
      nodes_ = patch.nodes.data();  // of the parts, once there are any
      seen_.assign(patch.nodes.size(), kUnseen);
      patch.tree.ForEach(near, [&](std::int32_t leaf) {
        std::int32_t side;
        if (!test_.MayLoadAbove(patch.leaves[leaf], &side)) return;
        for (std::int32_t i = patch.leaves[leaf].first; i < patch.leaves[leaf].last; ++i) {
          const AreaPatch::Triangle& largest = patch.triangles[i];
          if (largest.last >= 0) {
            // Its neighbours' parts may share its nodes, and tell what falls to them.
            AddSmallest(patch.has_parts ? PartsOfPatch().triangles[PartsOfPatch().place[i]]
                                        : largest);
          } else if (side >= 0) {
            AddFlat(largest, side, test_.ClearanceAbove(side, CornersOf(largest)));
          } else if (test_.MayLoad(CornersOf(largest))) {
            AddLargest(patch, i);
          }
        }
      });
      Close(first_triangle);
      // Each may append more.
      for (std::size_t i = 0; i < deeper_.size(); ++i) {
        const AreaParts& parts = sampled_.parts(*deeper_[i].place);
        patch_ = parts.patch;
        number_ = deeper_[i].number;
        first_triangle = candidates_.triangles.size();
        nodes_ = parts.nodes.data();
        seen_.assign(parts.nodes.size(), kUnseen);
        if (!AddIfFlat(parts.triangles[0])) AddParts(parts, 0);
        Close(first_triangle);
      }
      deeper_.clear();
      number_ = -1;
    });
  }

 private:
  static constexpr float kUnseen = -std::numeric_limits<float>::max();
  static constexpr float kUnasked = std::numeric_limits<float>::quiet_NaN();
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();

  Corners CornersOf(const AreaPatch::Triangle& triangle) const {
    return {nodes_[triangle.node[0]], nodes_[triangle.node[1]], nodes_[triangle.node[2]]};
  }

  // The patch, of which these triangles are.
  void Close(std::size_t first_triangle) {
    if (candidates_.triangles.size() == first_triangle) return;
    TakeNodes(first_triangle);
    candidates_.parts.push_back({patch_, static_cast<std::int32_t>(candidates_.nodes.size()),
                                 static_cast<std::int32_t>(candidates_.triangles.size()), number_});
  }

  void AddLargest(const AreaPatch& patch, std::int32_t i) {
    const AreaPatch::Triangle& whole = patch.triangles[i];
    if (AddIfFlat(whole)) return;
    const AreaParts& parts = PartsOfPatch();
    AddParts(parts, parts.place[i]);
  }

  const AreaParts& PartsOfPatch() {
    const AreaParts& parts = sampled_.parts(patch_);
    nodes_ = parts.nodes.data();
    if (seen_.size() < parts.nodes.size()) seen_.resize(parts.nodes.size(), kUnseen);
    return parts;
  }

  void AddParts(const AreaParts& parts, std::int32_t place) {
    const AreaPatch::Triangle& triangle = parts.triangles[place];
    const std::size_t open = candidates_.triangles.size();
    const bool ask = !test_.IsNeverFlat(CornersOf(triangle));
    if (ask) Push(triangle, AreaCandidates::kOpen, -kInfinity);
    for (std::int32_t i = place + 1; i < triangle.last; i = parts.triangles[i].last) {
      const AreaPatch::Triangle& part = parts.triangles[i];
      if (part.last == i + 1 && part.deeper < 0) {
        AddSmallest(part);
        continue;
      }
      const Corners corners = CornersOf(part);
      if (!test_.MayLoad(corners)) continue;
      if (part.deeper >= 0) {
        AddDeeper(part, parts.deeper[part.deeper]);
      } else if (!AddIfFlat(part)) {
        AddParts(parts, i);
      }
    }
    if (ask)
      candidates_.triangles[open].last = static_cast<std::int32_t>(candidates_.triangles.size());
  }

  void AddDeeper(const AreaPatch::Triangle& triangle, const AreaParts::Deeper& place) {
    std::int32_t number = -1;
    if (!test_.at_one_pose) {
      number = candidates_.num_deeper++;
      Push(triangle, AreaCandidates::kDeeper, -kInfinity);
      candidates_.triangles.back().deeper = number;
    }
    deeper_.push_back({&place, number});
  }

  bool AddIfFlat(const AreaPatch::Triangle& triangle) {
    const Corners corners = CornersOf(triangle);
    if (test_.IsRound(corners)) return false;
    const std::int32_t ground = test_.GroundUnder(corners);
    if (ground >= 0) AddFlat(triangle, ground, test_.ClearanceAbove(ground, corners));
    return ground >= 0;
  }

  void AddFlat(const AreaPatch::Triangle& triangle, std::int32_t ground, float clearance) {
    if (!(test_.at_one_pose && clearance > 0)) Push(triangle, ground, clearance);
  }

  void AddSmallest(const AreaPatch::Triangle& triangle) {
    const Corners corners = CornersOf(triangle);
    if (test_.IsRound(corners)) {
      const float least = test_.ClearanceAnywhere(corners);
      if (least > test_.Farthest(corners)) return;
      const std::int32_t ground = test_.GroundUnder(corners);
      if (ground >= 0) return AddFlat(triangle, ground, test_.ClearanceAbove(ground, corners));
      if (!test_.at_one_pose) {
        return Push(triangle, AreaCandidates::kOpenSmallest, least);
      }
    }
    float least = kInfinity;
    for (const std::int32_t i : triangle.node) {
      float& clearance = seen_[i];
      if (clearance == kUnseen || std::isnan(clearance)) {
        clearance = std::max(RoundedDown(test_.Clearance(nodes_[i])), -kInfinity);
      }
      least = std::min(least, clearance);
    }
    if (!(least > 0)) Push(triangle, AreaCandidates::kSmallest, least);
  }

  void Push(const AreaPatch::Triangle& triangle, std::int32_t ground, float clearance) {
    for (const std::int32_t i : triangle.node) {
      if (seen_[i] == kUnseen) seen_[i] = kUnasked;
    }
    const auto last = static_cast<std::int32_t>(candidates_.triangles.size()) + 1;
    candidates_.triangles.push_back({triangle.node, last, ground, triangle.area, triangle.share});
    candidates_.clearances.push_back(clearance);
  }

  // Of the patch, in its order; the triangles then speak of them.
  void TakeNodes(std::size_t first_triangle) {
    place_of_.resize(std::max(place_of_.size(), seen_.size()));
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      if (seen_[i] == kUnseen) continue;
      place_of_[i] = static_cast<std::int32_t>(candidates_.nodes.size());
      candidates_.nodes.push_back({nodes_[i], static_cast<std::int32_t>(i), seen_[i]});
    }
    for (std::size_t t = first_triangle; t < candidates_.triangles.size(); ++t) {
      for (std::int32_t& node : candidates_.triangles[t].node) node = place_of_[node];
    }
  }

  const AreaNodes& sampled_;
  const Test& test_;
  AreaCandidates& candidates_;
  // Clearances of the patch's nodes, as far as asked, and their places among the candidates.
  std::vector<float>& seen_ = Scratch<std::vector<float>>([] {});
  std::vector<std::int32_t>& place_of_ = Scratch<std::vector<std::int32_t>>([] {});
  struct Deeper {
    const AreaParts::Deeper* place;
    std::int32_t number;
  };
  std::vector<Deeper>& deeper_ = Scratch<std::vector<Deeper>>([] {});
  const Vec3* nodes_ = nullptr;  // of the patch
  std::int32_t patch_ = -1, number_ = -1;
};

}  // namespace contact_toolkit
