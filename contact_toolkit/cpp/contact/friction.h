// Friction that sticks: a tangential spring and damper behind each normal spring, limited by the
// friction cone. The spring hangs on an anchor, which changes once per accepted step, never inside
// a force evaluation.
#pragma once

#include <algorithm>

namespace contact_toolkit {

struct Friction {
  double static_coefficient = 0;   // [-]
  double dynamic_coefficient = 0;  // [-] at most the static one
  double stiffness_ratio = 0;      // [-] tangential over normal spring constant; 0: no anchors
  double damping_time = 0;         // [s] tangential damping over normal spring constant
  double damping_slope = 0;  // [s/m] tangential damping over tangential stiffness and deformation

  bool active() const { return static_coefficient > 0; }
  bool anchored() const { return active() && stiffness_ratio > 0; }

  // [N] What the tangential force may reach; a spring that slides keeps sliding at the lower limit.
  double Limit(double normal_force, bool sliding) const {
    return (sliding ? dynamic_coefficient : static_coefficient) * std::max(0.0, normal_force);
  }
  // [N/m] Of a normal spring of this constant.
  double TangentialStiffness(double stiffness) const { return stiffness_ratio * stiffness; }
  // [N s/m] Of a normal spring of this constant, now carrying this elastic force.
  double TangentialDamping(double stiffness, double elastic) const {
    return damping_time * stiffness + damping_slope * stiffness_ratio * elastic;
  }
};

}  // namespace contact_toolkit
