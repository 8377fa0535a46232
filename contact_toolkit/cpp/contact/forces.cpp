#include "contact/forces.h"

namespace contact_toolkit {
namespace {

bool AreAlike(const Vec3& a, const Vec3& b, double tolerance) {
  return SquaredNorm(a - b) <= tolerance * tolerance * (1 + SquaredNorm(a));
}
bool AreAlike(const Pose& a, const Pose& b) {
  bool alike = AreAlike(a.p, b.p, 1e-12);
  for (int i = 0; i < 3; ++i) alike = alike && AreAlike(a.R.row[i], b.R.row[i], 1e-12);
  return alike;
}
bool AreAlike(const Twist& a, const Twist& b) {
  return AreAlike(a.w, b.w, 1e-8) && AreAlike(a.v, b.v, 1e-8);
}

}  // namespace

bool Forces::AreAt(std::span<const Pose> X_FB, std::span<const Twist> V) const {
  for (std::size_t i = 0; i < V_FB.size(); ++i) {
    if (!AreAlike(loaded->X_FB[i], X_FB[i]) || !AreAlike(V_FB[i], V[i])) return false;
  }
  return true;
}

}  // namespace contact_toolkit
