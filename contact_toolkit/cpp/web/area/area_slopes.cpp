#include "web/area/area_slopes.h"

#include <vector>

#include "base/scratch.h"

namespace contact_toolkit {

Symmetric3 Rotated(const Mat3& R, const Symmetric3& m) {
  if (m == Symmetric3{}) return m;
  const Vec3 c[3] = {m * R.row[0], m * R.row[1], m * R.row[2]};
  return {Dot(R.row[0], c[0]), Dot(R.row[1], c[1]), Dot(R.row[2], c[2]),
          Dot(R.row[0], c[1]), Dot(R.row[0], c[2]), Dot(R.row[1], c[2])};
}

void FindElasticSlopes(std::span<const LoadCoupling> couplings, std::span<const std::int32_t> row,
                       double stiffness, SpringSet* springs) {
  auto& deepening = Scratch<std::vector<Slope>>([] {});  // K times that of the node itself
  deepening.resize(springs->size());
  for (std::size_t i = 0; i < springs->size(); ++i) {
    const Vec3 push = -stiffness * springs->steepness[i] * springs->normal_A[i];
    deepening[i] = {Cross(springs->p_AC[i], push), push};
  }
  std::vector<Slope>& elastic = springs->slopes.elastic;
  elastic.assign(springs->size(), {});
  for (const auto& [loaded, deepened, slope] : couplings) {
    for (int i = 0; i < 3; ++i) {
      const std::int32_t at = row[loaded[i]];
      if (at < 0) continue;
      for (int j = 0; j < 3; ++j) {
        if (row[deepened[j]] >= 0) elastic[at] += slope[i][j] * deepening[row[deepened[j]]];
      }
    }
  }
}

}  // namespace contact_toolkit
