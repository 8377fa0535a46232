#include "contact/anchor_update.h"

#include <cmath>
#include <utility>
#include <vector>

namespace contact_toolkit {
namespace {

double Square(double x) { return x * x; }

}  // namespace

std::shared_ptr<const AnchorSet> UpdateAnchors(const Friction& friction, const SpringSet& springs,
                                               const Pose& X_AB, std::span<const Stretch> stretches,
                                               std::span<const SpringForce> forces,
                                               std::shared_ptr<const AnchorSet> before) {
  const Pose X_BA = Inverse(X_AB);
  const std::span<const Anchor> old = before ? before->anchors() : std::span<const Anchor>{};
  std::vector<Anchor> after;
  bool changed = old.size() != springs.size() || !before;
  if (changed) after.reserve(springs.size());
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double load = springs.steepness[i] * forces[i].normal;
    const double stiffness = springs.stiffness[i];
    const Stretch& stretch = stretches[i];
    const double squared_pull =
        Square(friction.TangentialStiffness(stiffness)) * SquaredNorm(stretch.stretch_A);
    const bool slipped = squared_pull > Square(friction.Limit(load, stretch.sliding));
    const bool sliding = slipped || (stretch.sliding && forces[i].moving_on);
    const Anchor* kept = stretch.anchor >= 0 && !slipped ? &old[stretch.anchor] : nullptr;
    if (!changed) {
      if (kept == &old[i] && kept->stiffness == stiffness && kept->sliding == sliding) continue;
      changed = true;
      after.reserve(springs.size());
      after.assign(old.begin(), old.begin() + i);
    }
    if (kept) {
      after.push_back({kept->key, kept->p_AQ, kept->p_BQ, stiffness, sliding});
    } else {
      const double share = slipped ? friction.Limit(load, sliding) / std::sqrt(squared_pull) : 1.0;
      const Vec3& p_AC = springs.p_AC[i];
      const Vec3 p_BQ = X_BA * (p_AC - share * stretch.stretch_A);
      after.push_back({springs.key[i], p_AC, p_BQ, stiffness, sliding});
    }
  }
  if (!changed) return before;
  return std::make_shared<AnchorSet>(std::move(after));
}

}  // namespace contact_toolkit
