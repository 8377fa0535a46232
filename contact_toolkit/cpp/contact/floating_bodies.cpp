#include "contact/floating_bodies.h"

#include <algorithm>
#include <utility>

namespace contact_toolkit {

FloatingBodies::FloatingBodies(std::vector<FloatingBody> floating, std::vector<double> X_FB,
                               int num_positions, int num_velocities)
    : floating_(std::move(floating)),
      X_FB_(std::move(X_FB)),
      num_positions_(num_positions),
      num_velocities_(num_velocities) {}

void FloatingBodies::Gather(std::span<const double> state, std::vector<double>* X_FB,
                            std::vector<double>* V_FB) const {
  *X_FB = X_FB_;
  V_FB->assign(6 * num_bodies(), 0.0);
  for (const FloatingBody& floating : floating_) {
    const double* q = state.data() + floating.q_start;
    const double* v = state.data() + num_positions_ + floating.v_start;
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double s = 2 / (w * w + x * x + y * y + z * z);
    double* X = X_FB->data() + 16 * static_cast<std::size_t>(floating.body);
    X[0] = 1 - s * (y * y + z * z), X[1] = s * (x * y - w * z), X[2] = s * (x * z + w * y);
    X[4] = s * (x * y + w * z), X[5] = 1 - s * (x * x + z * z), X[6] = s * (y * z - w * x);
    X[8] = s * (x * z - w * y), X[9] = s * (y * z + w * x), X[10] = 1 - s * (x * x + y * y);
    X[3] = q[4], X[7] = q[5], X[11] = q[6];
    std::copy_n(v, 6, V_FB->data() + 6 * static_cast<std::size_t>(floating.body));
  }
}

std::vector<double> FloatingBodies::Scatter(std::span<const double> body_wrenches) const {
  std::vector<double> generalized(num_velocities_, 0.0);
  for (const FloatingBody& floating : floating_) {
    std::copy_n(body_wrenches.data() + 6 * static_cast<std::size_t>(floating.body), 6,
                generalized.data() + floating.v_start);
  }
  return generalized;
}

}  // namespace contact_toolkit
