#include "step/body_kinematics.h"

#include <algorithm>

namespace contact_toolkit {
namespace {

Vec3 VectorAt(std::span<const double> values, int first) {
  return {values[first], values[first + 1], values[first + 2]};
}

Mat3 RotationOf(double w, double x, double y, double z) {
  const double s = 2 / (w * w + x * x + y * y + z * z);
  return {{Vec3{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
           Vec3{s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)},
           Vec3{s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}}};
}

}  // namespace

Mat3 RotationOf(const double* q) { return RotationOf(q[0], q[1], q[2], q[3]); }

Mat3 QuaternionStep(const Vec3& w, double step) {
  return RotationOf(1, 0.5 * step * w.x, 0.5 * step * w.y, 0.5 * step * w.z);
}

BodyKinematics::BodyKinematics(const StepTopology& topology, const StepProblem& problem)
    : topology_(topology), problem_(problem) {}

Pose BodyKinematics::EndOfRoot(const StepTree& tree, std::span<const double> v) const {
  const double* q = problem_.q0.data() + tree.q_start;
  const double h = 0.5 * problem_.step;
  const Vec3 w = h * VectorAt(v, tree.v_start);
  // (1, w) ⊗ q, as the multibody system steps it.
  const double q0 = q[0] - (w.x * q[1] + w.y * q[2] + w.z * q[3]);
  const double q1 = q[1] + w.x * q[0] + w.y * q[3] - w.z * q[2];
  const double q2 = q[2] + w.y * q[0] + w.z * q[1] - w.x * q[3];
  const double q3 = q[3] + w.z * q[0] + w.x * q[2] - w.y * q[1];
  return {RotationOf(q0, q1, q2, q3),
          Vec3{q[4], q[5], q[6]} + problem_.step * VectorAt(v, tree.v_start + 3)};
}

Pose BodyKinematics::PoseOf(int body, std::span<const double> v) const {
  const StepBody& moving = topology_.bodies[body];
  if (moving.tree < 0) return problem_.X_FB[body];
  const StepTree& tree = topology_.trees[moving.tree];
  if (tree.q_start >= 0) return EndOfRoot(tree, v) * moving.X_RB;
  const std::size_t nv = topology_.num_velocities;
  const double* J = problem_.jacobian.data() + 6 * nv * body + tree.v_start;
  double V[6] = {};
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < tree.nv; ++k) {
      const int dof = tree.v_start + k;
      V[i] += J[i * nv + k] * (v[dof] - problem_.v_reference[dof]);
    }
  }
  const Pose& X = problem_.X_FB[body];
  return {QuaternionStep({V[0], V[1], V[2]}, problem_.step) * X.R,
          X.p + problem_.step * Vec3{V[3], V[4], V[5]}};
}

Twist BodyKinematics::TwistOf(int body, std::span<const double> v) const {
  const StepBody& moving = topology_.bodies[body];
  if (moving.tree < 0) return {};
  const StepTree& tree = topology_.trees[moving.tree];
  if (tree.q_start >= 0) {
    const Vec3 w = VectorAt(v, tree.v_start), velocity = VectorAt(v, tree.v_start + 3);
    const Vec3 arm = EndOfRoot(tree, v).R * moving.X_RB.p;
    return {w, velocity + Cross(w, arm)};
  }
  const std::size_t nv = topology_.num_velocities;
  const double* J = problem_.jacobian.data() + 6 * nv * body + tree.v_start;
  double V[6] = {};
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < tree.nv; ++k) V[i] += J[i * nv + k] * v[tree.v_start + k];
  }
  return {{V[0], V[1], V[2]}, {V[3], V[4], V[5]}};
}

Vec3 BodyKinematics::OriginOf(int body, const Pose& X_FB) const {
  const StepBody& moving = topology_.bodies[body];
  if (moving.tree < 0 || topology_.trees[moving.tree].q_start < 0) return X_FB.p;
  return X_FB.p - X_FB.R * (Transpose(moving.X_RB.R) * moving.X_RB.p);
}

void BodyKinematics::Differentiate(int body, std::span<const double> v,
                                   std::vector<Change>* changes) const {
  const StepTree& tree = topology_.trees[topology_.bodies[body].tree];
  const double h = problem_.step;
  const bool floats = tree.q_start >= 0;
  const std::size_t nv = topology_.num_velocities;
  const double* J = floats ? nullptr : problem_.jacobian.data() + 6 * nv * body + tree.v_start;
  changes->clear();
  // Half of the rotation, and what a change of it turns by.
  Vec3 a;
  if (floats) a = 0.5 * h * VectorAt(v, tree.v_start);
  for (int k = 0; k < tree.nv; ++k) {
    Change change;
    change.dof = k;
    if (floats) {
      (k < 3 ? change.spin : change.speed)[k % 3] = 1;
      changes->push_back(change);
      continue;
    }
    for (int i = 0; i < 3; ++i) {
      change.spin[i] = J[i * nv + k];
      change.speed[i] = J[(3 + i) * nv + k];
    }
    if (SquaredNorm(change.spin) == 0 && SquaredNorm(change.speed) == 0) continue;
    changes->push_back(change);
    a += (0.5 * h * (v[tree.v_start + k] - problem_.v_reference[tree.v_start + k])) * change.spin;
  }
  for (Change& change : *changes) {
    change.turn = h / (1 + SquaredNorm(a)) * (change.spin + Cross(a, change.spin));
    change.way = h * change.speed;
  }
}

}  // namespace contact_toolkit
