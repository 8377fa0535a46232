// The nonlinear damper: F = (elastic force) · (1 + 3/2 α δ̇), zero where that would pull unless the
// contact is adhesive. Hunt and Crossley, "Coefficient of restitution interpreted as damping in
// vibroimpact", J. Appl. Mech. 42(2), 1975.
//
// That law damps next to nothing when next to nothing moves. With a settling speed s and a smallest
// speed w, δ̇ counts for δ̇ + s δ̇/(w + |δ̇|) · s/(s + |δ̇|): 1 + s/w times as much where it is small,
// about as much as s up to s, and for itself where it is large.
#pragma once

#include <cmath>

namespace contact_toolkit {

struct ContactLaw {
  double alpha = 0;       // [s/m] restitution falls by α a unit of impact velocity
  bool adhesion = false;  // let the damping term pull
  double settling = 0;    // [m/s] s
  double smallest = 0;    // [m/s] w

  // [-] By how much a force exceeds the elastic one, as a share of that, at a rate of deformation.
  double Damping(double rate) const {
    if (!(settling > 0)) return 1.5 * alpha * rate;
    const double speed = std::abs(rate), share = settling / (settling + speed);
    return 1.5 * alpha * rate * (1 + settling * share / (smallest + speed));
  }
  // [s/m] Its derivative.
  double DampingSlope(double rate) const {
    if (!(settling > 0)) return 1.5 * alpha;
    const double speed = std::abs(rate), share = settling / (settling + speed);
    const double ratio = share / (smallest + speed);
    return 1.5 * alpha * (1 + (smallest * settling - speed * speed) * ratio * ratio);
  }
  // elastic [N] ≥ 0; rate [m/s] of deformation, positive when approaching.
  double NormalForce(double elastic, double rate) const {
    const double force = elastic * (1 + Damping(rate));
    return adhesion || force > 0 ? force : 0.0;
  }
};

}  // namespace contact_toolkit
