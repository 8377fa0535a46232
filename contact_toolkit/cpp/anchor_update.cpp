#include "anchor_update.h"

#include <utility>

namespace contact_toolkit {

std::shared_ptr<const AnchorSet> UpdateAnchors(const Friction& friction, const SpringSet& springs,
                                               const Pose& X_AB, std::span<const Stretch> stretches,
                                               std::span<const SpringForce> forces,
                                               std::shared_ptr<const AnchorSet> before) {
  const Pose X_BA = Inverse(X_AB);
  bool changed = !before || before->anchors().size() != springs.size();
  std::vector<Anchor> after;
  after.reserve(springs.size());
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double load = Norm(springs.gradient_A[i]) * forces[i].normal;
    const double stiffness = springs.stiffness[i];
    Vec3 stretch_A = stretches[i].stretch_A;
    bool sliding = stretches[i].sliding;
    const double pull = friction.TangentialStiffness(stiffness) * Norm(stretch_A);
    const bool slipped = pull > friction.Limit(load, sliding);
    if (slipped) {
      sliding = true;
      stretch_A = friction.Limit(load, sliding) / pull * stretch_A;
    } else {
      sliding = sliding && forces[i].moving_on;
    }
    if (stretches[i].anchor >= 0 && !slipped) {
      const Anchor& kept = before->anchors()[stretches[i].anchor];
      changed |= static_cast<std::size_t>(stretches[i].anchor) != i ||
                 kept.stiffness != stiffness || kept.sliding != sliding;
      after.push_back(kept);
      after.back().stiffness = stiffness;
      after.back().sliding = sliding;
    } else {
      changed = true;
      const Vec3& p_AC = springs.p_AC[i];
      after.push_back({springs.key[i], p_AC, X_BA * (p_AC - stretch_A), stiffness, sliding});
    }
  }
  if (!changed) return before;
  return std::make_shared<AnchorSet>(std::move(after));
}

}  // namespace contact_toolkit
