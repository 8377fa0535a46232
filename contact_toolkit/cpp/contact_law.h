// The nonlinear damper: F = (elastic force) · (1 + 3/2 α δ̇), zero where that would pull unless the
// contact is adhesive. Hunt and Crossley, "Coefficient of restitution interpreted as damping in
// vibroimpact", J. Appl. Mech. 42(2), 1975.
#pragma once

namespace contact_toolkit {

struct ContactLaw {
  double alpha = 0;       // [s/m] restitution falls by α a unit of impact velocity
  bool adhesion = false;  // let the damping term pull

  // elastic [N] ≥ 0; rate [m/s] of deformation, positive when approaching.
  double NormalForce(double elastic, double rate) const {
    const double force = elastic * (1 + 1.5 * alpha * rate);
    return adhesion || force > 0 ? force : 0.0;
  }
};

}  // namespace contact_toolkit
