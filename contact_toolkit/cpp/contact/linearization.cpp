#include "contact/linearization.h"

namespace contact_toolkit {
namespace {

void SetColumn(int k, const Slope& column, Mat6* m) {
  for (int i = 0; i < 3; ++i) {
    (*m)[i][k] = column.rotation[i];
    (*m)[3 + i][k] = column.translation[i];
  }
}

}  // namespace

void Linearization::Resize(std::size_t pairs) {
  pair.resize(pairs);
  bodies.resize(pairs);
  wrench.resize(pairs);
  stiffness.resize(pairs);
  damping.resize(pairs);
}

PairLinearization ReferToBody(const PairLinearization& of_geometry, const Mat3& R_FG,
                              const Vec3& p_BG_F, const Vec3& force, const Vec3& w) {
  const Mat3 R_GF = Transpose(R_FG);
  const auto moved = [&](const Mat6& m, const Vec3& rotation, const Vec3& translation) {
    const Slope at_G{R_GF * rotation, R_GF * (translation + Cross(rotation, p_BG_F))};
    const Slope wrench_G = m * at_G;
    const Vec3 pull = R_FG * wrench_G.translation;
    return Slope{R_FG * wrench_G.rotation + Cross(p_BG_F, pull), pull};
  };
  PairLinearization result;
  for (int k = 0; k < 3; ++k) {
    Vec3 axis;
    axis[k] = 1;
    SetColumn(k, moved(of_geometry.damping, axis, {}), &result.damping);
    SetColumn(3 + k, moved(of_geometry.damping, {}, axis), &result.damping);
    SetColumn(3 + k, moved(of_geometry.stiffness, {}, axis), &result.stiffness);
    // The arm from the body's origin turns, and with it the velocity and the moment.
    const Vec3 swing = Cross(axis, p_BG_F);
    Slope turned = moved(of_geometry.stiffness, axis, {});
    turned += moved(of_geometry.damping, {}, Cross(w, swing));
    turned.rotation -= Cross(swing, force);
    SetColumn(k, turned, &result.stiffness);
  }
  return result;
}

}  // namespace contact_toolkit
