#include "web/area/area_memory.h"

#include <algorithm>
#include <utility>

namespace contact_toolkit {

double AreaMemory::Way(const Vec3& p, double radius) const {
  return slack * std::max(1.0, (Norm(p - around.center) + radius) / around.radius);
}

void AreaMemory::KeepTriangles(std::int32_t first, std::int32_t last, bool edges,
                               AreaCandidates* kept) const {
  for (std::int32_t t = first; t < last; t = candidates.triangles[t].last) {
    const AreaCandidates::Triangle& triangle = candidates.triangles[t];
    const std::size_t place = kept->triangles.size();
    const bool open = triangle.ground == AreaCandidates::kOpen;
    const auto may_be_loaded = [&](std::int32_t i) {
      return candidates.clearances[t] <= Way(candidates.nodes[i].p, 0);
    };
    if (!open && !std::ranges::any_of(triangle.node, may_be_loaded)) continue;
    kept->triangles.push_back(triangle);
    kept->clearances.push_back(candidates.clearances[t]);
    if (open) KeepTriangles(t + 1, triangle.last, edges, kept);
    // An open triangle with a loaded corner has a part with it.
    if (open && !edges && kept->triangles.size() == place + 1) {
      kept->triangles.pop_back();
      kept->clearances.pop_back();
    } else {
      kept->triangles[place].last = static_cast<std::int32_t>(kept->triangles.size());
    }
  }
}

void AreaMemory::Prune(bool edges) {
  AreaCandidates kept;
  std::vector<std::int32_t> place_of(candidates.nodes.size(), -1);
  std::int32_t node = 0, triangle = 0;
  for (const AreaCandidates::Part& part : candidates.parts) {
    const std::size_t first = kept.triangles.size();
    KeepTriangles(triangle, part.last_triangle, edges, &kept);
    triangle = part.last_triangle;
    for (std::size_t t = first; t < kept.triangles.size(); ++t) {
      for (const std::int32_t i : kept.triangles[t].node) place_of[i] = 0;
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
                          static_cast<std::int32_t>(kept.triangles.size()), part.deeper});
  }
  kept.num_deeper = candidates.num_deeper;
  candidates = std::move(kept);
  for (const AreaCandidates::Node& each : candidates.nodes) {
    around.radius = std::max(around.radius, Norm(each.p - around.center));
  }
}

}  // namespace contact_toolkit
