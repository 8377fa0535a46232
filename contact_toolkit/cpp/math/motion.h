// The motion of B in A between two poses: Bo moves along a straight line at constant speed while B
// turns about a fixed axis at constant rate (the shorter way). s in [0, 1] is the fraction of the
// motion:
//   X_AB(s) = { exp(s angle [axis_A]) R_start,  p_start + s translation }.
#pragma once

#include <vector>

#include "math/vec.h"

namespace contact_toolkit {

class Motion {
 public:
  // Both rotation matrices must be proper. Half a turn goes either way.
  Motion(const Pose& X_AB_start, const Pose& X_AB_end);

  // Exactly the given poses at s = 0 and s = 1.
  Pose At(double s) const;

  const Vec3& translation() const { return translation_; }  // of Bo, in A
  const Vec3& axis_A() const { return axis_A_; }            // unit; zero without rotation
  const Vec3& axis_B() const { return axis_B_; }
  double angle() const { return angle_; }  // [rad], 0 to pi
  bool rotates() const { return angle_ > 0; }
  bool still() const { return !rotates() && translation_ == Vec3{}; }

  // Distance of a point of B from the line through Bo along the axis: how far it is swung.
  double Radius(const Vec3& p_BQ) const { return Norm(Cross(axis_B_, p_BQ)); }

 private:
  Pose start_, end_;
  Vec3 translation_, axis_A_, axis_B_;
  double angle_ = 0;
};

// A part of the motion, with its halves once they have been asked for.
struct TimeSlice {
  double begin, end;
  Pose X_begin, X_end;
  Mat3 R_middle;
  int halves = -1;  // index of the first half; the second follows
};

// A binary tree of slices of a motion up to `end`, grown on demand. slices[0] is all of it.
class TimeSlices {
 public:
  TimeSlices(const Motion& motion, double end);

  const Motion& motion() const { return motion_; }
  const TimeSlice& operator[](int i) const { return slices_[i]; }
  // Index of the first half of slice i.
  int Halves(int i);

 private:
  TimeSlice Make(double begin, double end, const Pose& X_begin, const Pose& X_end) const;

  const Motion& motion_;
  std::vector<TimeSlice> slices_;
};

}  // namespace contact_toolkit
