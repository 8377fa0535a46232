// Conservative advancement of one convex point set past another (Mirtich 1996; Zhang, Lee, Kim, ACM
// TOG 25(3), 2006): how far a motion may go on before the two can be closer than a given distance.
#pragma once

#include <span>
#include <vector>

#include "math/motion.h"
#include "query/swept/gjk.h"

namespace contact_toolkit {

// Least distance at s of the hull of `a` (in A) from that of `b` (in B), and the way on from there.
class PairAt {
 public:
  // `scratch` holds B's points in A afterwards; it must outlive this.
  PairAt(std::span<const Vec3> a, std::span<const Vec3> b, const Motion& motion, double s,
         std::vector<Vec3>* scratch);

  const GjkResult& gjk() const { return gjk_; }

  // A share of the motion, measured from s forwards (direction 1) or backwards (-1), during which
  // the sets stay at least `separation` apart; zero when they may already be closer. Along the
  // separating plane's normal no point of B closes in by more than c t + k t²/2, c its speed now, k
  // its greatest acceleration: so each step is Newton's, and none oversteps.
  double SafeStep(double separation, int direction) const;

  // Whether B's witness point is moving towards A.
  bool approaching() const { return ClosingSpeed(gjk_.p_B) > 0; }

 private:
  double ClosingSpeed(const Vec3& p_A) const {
    return Dot(gjk_.normal,
               motion_.translation() + motion_.angle() * Cross(motion_.axis_A(), p_A - p_ABo_));
  }

  std::span<const Vec3> b_;
  const Motion& motion_;
  Vec3 p_ABo_;
  const std::vector<Vec3>& b_A_;
  GjkResult gjk_;
};

}  // namespace contact_toolkit
