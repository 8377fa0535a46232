#include "query/swept/pair_advance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace contact_toolkit {

PairAt::PairAt(std::span<const Vec3> a, std::span<const Vec3> b, const Motion& motion, double s,
               std::vector<Vec3>* scratch)
    : b_(b), motion_(motion), b_A_(*scratch) {
  const Pose X_AB = motion.At(s);
  p_ABo_ = X_AB.p;
  scratch->resize(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) (*scratch)[i] = X_AB * b[i];
  gjk_ = Gjk(a, *scratch);
}

double PairAt::SafeStep(double separation, int direction) const {
  const Vec3& n = gjk_.normal;  // from B towards A
  double highest = -std::numeric_limits<double>::infinity();
  for (const Vec3& p : b_A_) highest = std::max(highest, Dot(n, p));
  const double across = Norm(Cross(n, motion_.axis_A()));  // accelerations are normal to the axis
  const double squared_rate = motion_.angle() * motion_.angle();
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < b_A_.size(); ++i) {
    const double gap = gjk_.lower_bound - separation + (highest - Dot(n, b_A_[i]));
    if (!(gap > 0)) return 0;
    const double speed = direction * ClosingSpeed(b_A_[i]);
    const double acceleration =
        motion_.rotates() ? squared_rate * motion_.Radius(b_[i]) * across : 0;
    // The root of gap = speed t + acceleration t²/2, in the form that does not cancel.
    const double root = std::sqrt(speed * speed + 2 * acceleration * gap);
    if (speed >= 0) {
      if (speed + root > 0) step = std::min(step, 2 * gap / (speed + root));
    } else if (acceleration > 0) {
      step = std::min(step, (root - speed) / acceleration);
    }
  }
  return step;
}

}  // namespace contact_toolkit
