#include "area_memory.h"

#include <algorithm>
#include <utility>

namespace contact_toolkit {

double AreaMemory::Way(const Vec3& p, double radius) const {
  return slack * std::max(1.0, (Norm(p - around.center) + radius) / around.radius);
}

void AreaMemory::Prune() {
  AreaCandidates kept;
  std::vector<std::int32_t> place_of(candidates.nodes.size(), -1);
  std::int32_t node = 0, triangle = 0;
  for (const AreaCandidates::Part& part : candidates.parts) {
    const std::size_t first = kept.triangles.size();
    for (; triangle < part.last_triangle; ++triangle) {
      const AreaPatch::Triangle& t = candidates.triangles[triangle];
      const auto may_be_loaded = [&](std::int32_t i) {
        return candidates.nodes[i].clearance <= Way(candidates.nodes[i].p, 0);
      };
      if (!std::ranges::any_of(t.node, may_be_loaded)) continue;
      kept.triangles.push_back(t);
      for (const std::int32_t i : t.node) place_of[i] = 0;
    }
    for (; node < part.last_node; ++node) {
      if (place_of[node] < 0) continue;
      place_of[node] = static_cast<std::int32_t>(kept.nodes.size());
      kept.nodes.push_back(candidates.nodes[node]);
    }
    if (kept.triangles.size() == first) continue;
    for (std::size_t t = first; t < kept.triangles.size(); ++t) {
      for (std::int32_t& i : kept.triangles[t].node) i = place_of[i];
    }
    kept.parts.push_back({part.patch, static_cast<std::int32_t>(kept.nodes.size()),
                          static_cast<std::int32_t>(kept.triangles.size())});
  }
  candidates = std::move(kept);
  for (const AreaCandidates::Node& each : candidates.nodes) {
    around.radius = std::max(around.radius, Norm(each.p - around.center));
  }
}

}  // namespace contact_toolkit
