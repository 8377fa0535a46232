#include "math/motion.h"

#include <algorithm>

namespace contact_toolkit {
namespace {

// Axis times sin(angle / 2), and cos(angle / 2) >= 0, of a rotation (Shepperd, J. Guidance and
// Control 1(3), 1978: divide by the largest component).
struct HalfTurn {
  Vec3 axis_sine;
  double cosine;
};

HalfTurn HalfTurnOf(const Mat3& R) {
  const double trace = R.row[0].x + R.row[1].y + R.row[2].z;
  const Vec3 skew{R.row[2].y - R.row[1].z, R.row[0].z - R.row[2].x, R.row[1].x - R.row[0].y};
  int i = 0;
  for (int k = 1; k < 3; ++k) {
    if (R.row[k][k] > R.row[i][i]) i = k;
  }
  HalfTurn q;
  if (trace > R.row[i][i]) {
    const double w = std::sqrt(std::max(0.0, 1 + trace));  // 2 cosine
    q = {skew / (2 * w), w / 2};
  } else {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double x = std::sqrt(std::max(0.0, 1 + R.row[i][i] - R.row[j][j] - R.row[k][k]));
    q.axis_sine[i] = x / 2;
    q.axis_sine[j] = (R.row[i][j] + R.row[j][i]) / (2 * x);
    q.axis_sine[k] = (R.row[i][k] + R.row[k][i]) / (2 * x);
    q.cosine = skew[i] / (2 * x);
  }
  if (q.cosine < 0) q = {-q.axis_sine, -q.cosine};
  return q;
}

Mat3 RotationAbout(const Vec3& unit, double angle) {
  const double c = std::cos(angle), s = std::sin(angle), t = 1 - c;
  const Vec3& u = unit;
  return {{Vec3{c + t * u.x * u.x, t * u.x * u.y - s * u.z, t * u.x * u.z + s * u.y},
           Vec3{t * u.x * u.y + s * u.z, c + t * u.y * u.y, t * u.y * u.z - s * u.x},
           Vec3{t * u.x * u.z - s * u.y, t * u.y * u.z + s * u.x, c + t * u.z * u.z}}};
}

}  // namespace

Motion::Motion(const Pose& X_AB_start, const Pose& X_AB_end)
    : start_(X_AB_start), end_(X_AB_end), translation_(X_AB_end.p - X_AB_start.p) {
  if (start_.R.row == end_.R.row) return;
  const HalfTurn q = HalfTurnOf(end_.R * Transpose(start_.R));
  const double sine = Norm(q.axis_sine);
  if (sine == 0) return;
  angle_ = 2 * std::atan2(sine, q.cosine);
  axis_A_ = q.axis_sine / sine;
  axis_B_ = Transpose(start_.R) * axis_A_;
}

Pose Motion::At(double s) const {
  if (s <= 0) return start_;
  if (s >= 1) return end_;
  const Vec3 p = start_.p + s * translation_;
  return {rotates() ? RotationAbout(axis_A_, s * angle_) * start_.R : start_.R, p};
}

TimeSlices::TimeSlices(const Motion& motion, double end) : motion_(motion) {
  slices_.push_back(Make(0, end, motion.At(0), motion.At(end)));
}

TimeSlice TimeSlices::Make(double begin, double end, const Pose& X_begin, const Pose& X_end) const {
  return {begin, end, X_begin, X_end, motion_.At(0.5 * (begin + end)).R};
}

int TimeSlices::Halves(int i) {
  if (slices_[i].halves < 0) {
    const TimeSlice whole = slices_[i];
    const double middle = 0.5 * (whole.begin + whole.end);
    const Pose X_middle = motion_.At(middle);
    slices_[i].halves = static_cast<int>(slices_.size());
    slices_.push_back(Make(whole.begin, middle, whole.X_begin, X_middle));
    slices_.push_back(Make(middle, whole.end, X_middle, whole.X_end));
  }
  return slices_[i].halves;
}

}  // namespace contact_toolkit
