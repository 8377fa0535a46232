#include "math/hermite_motion.h"

#include <cmath>

namespace contact_toolkit {
namespace {

// Rotation by the vector's length about its direction (Rodrigues).
Mat3 Exp(const Vec3& v) {
  const double angle = Norm(v);
  const double s = angle > 1e-6 ? std::sin(angle) / angle : 1 - angle * angle / 6;
  const double half = angle > 1e-6 ? std::sin(angle / 2) / (angle / 2) : 1.0;
  const double c = 0.5 * half * half;  // (1 − cos) / angle²
  Mat3 R;
  for (int i = 0; i < 3; ++i) {
    Vec3 e;
    e[i] = 1;
    const Vec3 turned = Cross(v, e);
    const Vec3 column = e + s * turned + c * Cross(v, turned);
    for (int j = 0; j < 3; ++j) R.row[j][i] = column[j];
  }
  return R;
}

// The inverse for angles below π/2, more than any step turns.
Vec3 Log(const Mat3& R) {
  const Vec3 twice_sine{R.row[2].y - R.row[1].z, R.row[0].z - R.row[2].x, R.row[1].x - R.row[0].y};
  const double sine = 0.5 * Norm(twice_sine);
  return (sine > 1e-6 ? std::asin(std::min(sine, 1.0)) / sine : 1.0) * 0.5 * twice_sine;
}

// Angular velocity from the rate of a rotation vector, and back, to third order in the vector.
Vec3 AngularVelocity(const Vec3& v, const Vec3& rate) {
  const Vec3 turned = Cross(v, rate);
  return rate + 0.5 * turned + 1.0 / 6 * Cross(v, turned);
}
Vec3 RateOf(const Vec3& v, const Vec3& angular_velocity) {
  const Vec3 turned = Cross(v, angular_velocity);
  return angular_velocity - 0.5 * turned + 1.0 / 12 * Cross(v, turned);
}

}  // namespace

BodyState Halfway(const BodyState& start, const BodyState& end, double duration) {
  const auto position = [duration](const Vec3& way, const Vec3& v0, const Vec3& v1) {
    return 0.5 * way + duration / 8 * (v0 - v1);
  };
  const auto velocity = [duration](const Vec3& way, const Vec3& v0, const Vec3& v1) {
    return 1.5 * (way / duration) - 0.25 * (v0 + v1);
  };
  const Vec3 way = end.X_FB.p - start.X_FB.p;
  const Vec3 turn = Log(end.X_FB.R * Transpose(start.X_FB.R));
  const Vec3& rate0 = start.V_FB.w;
  const Vec3 rate1 = RateOf(turn, end.V_FB.w);
  const Vec3 half_turn = position(turn, rate0, rate1);
  return {{Exp(half_turn) * start.X_FB.R, start.X_FB.p + position(way, start.V_FB.v, end.V_FB.v)},
          {AngularVelocity(half_turn, velocity(turn, rate0, rate1)),
           velocity(way, start.V_FB.v, end.V_FB.v)}};
}

Pose Coasted(const BodyState& start, double duration) {
  return {Exp(duration * start.V_FB.w) * start.X_FB.R, start.X_FB.p + duration * start.V_FB.v};
}

}  // namespace contact_toolkit
