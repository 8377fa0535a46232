#include "step/free_motion.h"

#include "math/dense.h"
#include "step/step_equations.h"

namespace contact_toolkit {

std::vector<double> FreeMotion(const StepTopology& topology, std::span<const double> q0,
                               std::span<const double> v0, double step, const Vec3& gravity) {
  std::vector<double> v(v0.begin(), v0.end());
  for (std::size_t i = 0; i < topology.trees.size(); ++i) {
    const StepTree& tree = topology.trees[i];
    if (tree.q_start < 0) continue;
    Mat6 I = InertiaInF(topology, static_cast<int>(i), q0);
    const double* rates = v0.data() + tree.v_start;
    const Vec3 w{rates[0], rates[1], rates[2]};
    const double mass = I.m[3][3];
    // The mass moment m c stands in the lower left quarter, as −m c ×.
    const Vec3 moment{I.m[4][2], I.m[5][0], I.m[3][1]};
    const Mat3 about{{Vec3{I.m[0][0], I.m[0][1], I.m[0][2]}, Vec3{I.m[1][0], I.m[1][1], I.m[1][2]},
                      Vec3{I.m[2][0], I.m[2][1], I.m[2][2]}}};
    const Vec3 torque = Cross(moment, gravity) - Cross(w, about * w);
    const Vec3 force = mass * gravity - Cross(w, Cross(w, moment));
    double change[6] = {torque.x, torque.y, torque.z, force.x, force.y, force.z};
    if (!FactorCholesky(6, &I.m[0][0])) continue;
    SolveLower(6, &I.m[0][0], change);
    SolveLowerTransposed(6, &I.m[0][0], change);
    for (int k = 0; k < 6; ++k) v[tree.v_start + k] += step * change[k];
  }
  return v;
}

}  // namespace contact_toolkit
