// Pose and velocity of one body relative to another, both given in a common frame F. Positions are
// subtracted first, so that two bodies in contact far from F's origin lose no digits to the
// distance.
#pragma once

#include "math/vec.h"

namespace contact_toolkit {

inline Pose RelativePose(const Pose& X_FA, const Pose& X_FB) {
  const Mat3 R_AF = Transpose(X_FA.R);
  return {R_AF * X_FB.R, R_AF * (X_FB.p - X_FA.p)};
}

// Angular velocity and velocity of a body's origin.
struct Twist {
  Vec3 w, v;
};

// Velocity of A relative to B: of the point of A at position p is v + w × p.
inline Vec3 VelocityAt(const Twist& twist, const Vec3& p) { return twist.v + Cross(twist.w, p); }

// Motion of A relative to B as a field about Ao, everything expressed in F.
inline Twist RelativeTwist(const Pose& X_FA, const Twist& V_FA, const Pose& X_FB,
                           const Twist& V_FB) {
  return {V_FA.w - V_FB.w, V_FA.v - V_FB.v - Cross(V_FB.w, X_FA.p - X_FB.p)};
}

}  // namespace contact_toolkit
