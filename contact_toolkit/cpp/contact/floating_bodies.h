// Bodies whose motion stands in a multibody state [q; v] as it is: a unit quaternion [w x y z] and
// a position in q, angular and translational velocity in v, all in the common frame F.
#pragma once

#include <span>
#include <vector>

#include "math/vec.h"

namespace contact_toolkit {

struct FloatingBody {
  int body;              // row in the contact model
  int q_start, v_start;  // into q and into v
};

class FloatingBodies {
 public:
  // X_FB: the poses of all bodies of the model; those of the floating ones are replaced.
  FloatingBodies(std::vector<FloatingBody> floating, std::vector<double> X_FB, int num_positions,
                 int num_velocities);

  std::size_t num_bodies() const { return X_FB_.size() / 16; }
  int num_states() const { return num_positions_ + num_velocities_; }
  const std::vector<FloatingBody>& floating() const { return floating_; }

  // Row-major (4, 4) poses and velocities [w; v] of all bodies. Velocities of bodies that are not
  // floating are zero. The quaternion need not be of unit length.
  void Gather(std::span<const double> state, std::vector<double>* X_FB,
              std::vector<double>* V_FB) const;

  // Generalized forces from wrenches [torque about Bo; force]; those on other bodies are left out.
  std::vector<double> Scatter(std::span<const double> body_wrenches) const;

 private:
  std::vector<FloatingBody> floating_;
  std::vector<double> X_FB_;
  int num_positions_, num_velocities_;
};

}  // namespace contact_toolkit
