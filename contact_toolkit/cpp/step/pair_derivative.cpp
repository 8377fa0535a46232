#include "step/pair_derivative.h"

namespace contact_toolkit {
namespace {

// What of both parts a small rotation changes.
Slope Turn(const Vec3& rotation, const Slope& x) {
  return {Cross(rotation, x.rotation), Cross(rotation, x.translation)};
}

}  // namespace

PairDerivative::PairDerivative(const PairLinearization& linear, const Mat3& R, const Slope& wrench,
                               const Body& a, const Body& b, Symmetry symmetry)
    : stiffness_(Turned(R, linear.stiffness)),
      damping_(Turned(R, linear.damping)),
      wrench_(wrench),
      a_(a),
      b_(b),
      whole_(symmetry == Symmetry::kNone) {}

PairDerivative::Wrenches PairDerivative::ByA(const BodyKinematics::Change& change) const {
  const Vec3 swing = Cross(change.turn, a_.arm), way = change.way + swing;  // of the arm, of P
  const Slope motion{change.turn, way};
  Slope faster{change.spin, change.speed + Cross(change.spin, a_.arm)};
  if (whole_) faster.translation += Cross(a_.V.w, swing) - Cross(b_.V.w, way);
  return About(-1.0 * (stiffness_ * motion + damping_ * faster), swing, way);
}

// As if A moved the other way, and then all turned with B.
PairDerivative::Wrenches PairDerivative::ByB(const BodyKinematics::Change& change) const {
  const Slope motion{change.turn, change.way + Cross(change.turn, b_.arm)};
  Slope faster{change.spin, change.speed + Cross(change.spin, b_.arm)}, turned;
  if (whole_) {
    faster.translation -= Cross(b_.V.w, change.way);
    faster += Turn(change.turn, {a_.V.w - b_.V.w, a_.V.v - b_.V.v});
    turned = Turn(change.turn, wrench_);
  }
  return About(stiffness_ * motion + damping_ * faster + turned, {}, -change.way);
}

PairDerivative::Wrenches PairDerivative::About(const Slope& change, const Vec3& arm_a,
                                               const Vec3& arm_b) const {
  const auto moment = [&](const Vec3& arm, const Vec3& arm_change) {
    const Vec3 of_springs = change.rotation + Cross(arm, change.translation);
    return whole_ ? of_springs + Cross(arm_change, wrench_.translation) : of_springs;
  };
  return {{moment(a_.arm, arm_a), change.translation},
          {-moment(b_.arm, arm_b), -change.translation}};
}

}  // namespace contact_toolkit
