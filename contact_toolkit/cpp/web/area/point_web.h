// One spring for a ball so small beside what it touches that its surface need not be sampled: at
// its centre, where the other body's distance is known exactly. The gradient of k δ² / 2.
#pragma once

#include <memory>

#include "web/area/area_body.h"
#include "web/spring_web.h"

namespace contact_toolkit {

class PointWeb final : public SpringWeb {
 public:
  // `radius` [m] of the ball, which is A or B, about that geometry's origin; `other`: closed;
  // `stiffness` [N/m]. Throws std::invalid_argument naming the argument.
  PointWeb(bool ball_is_a, double radius, const AreaBody& other, double stiffness, double standoff);

  void FindSprings(const Pose& X_AB, SpringSet* springs) const override;
  double Clearance(const Pose& X_AB, double enough) const override;
  // The mesh that stands for a ball is smaller than the ball.
  double reach() const override { return standoff_ + radius_; }

 private:
  Vec3 CenterInOther(const Pose& X_AB) const { return ball_is_a_ ? Inverse(X_AB).p : X_AB.p; }

  bool ball_is_a_;
  double radius_, stiffness_, standoff_, capture_depth_;
  std::shared_ptr<const ProbedSurface> surface_;  // of the other
};

}  // namespace contact_toolkit
