// Checks poses on their way in: of every query, so not in Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>

#include "base/tolerances.h"
#include "bindings/arrays.h"

namespace contact_toolkit {
namespace {

// Raises ValueError unless m is a rigid transform within the core's range.
void CheckPose(const double* m, std::string_view called) {
  const auto name = [&] { return std::string(called); };  // only ever needed where it is wrong
  for (int i = 0; i < 16; ++i) {
    if (!std::isfinite(m[i])) {
      throw nb::value_error((name() + " has an entry that is not finite").c_str());
    }
  }
  const Pose pose = Pose::FromMatrix(m);
  const Vec3& p = pose.p;
  const double farthest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  if (farthest > kMaxCoordinate) {
    char number[32];
    std::snprintf(number, sizeof number, "%g", farthest);
    throw nb::value_error(
        (name() + " has a translation of " + number + " m, beyond the limit of 1e15 m").c_str());
  }
  const auto& R = pose.R.row;
  bool rigid = m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      rigid = rigid && std::abs(Dot(R[i], R[k]) - (i == k)) <= kPoseTolerance;
    }
  }
  if (!rigid || Dot(Cross(R[0], R[1]), R[2]) < 0) {
    std::string found;
    for (int i = 0; i < 16; ++i) {
      char number[32];
      std::snprintf(number, sizeof number, i % 4 == 0 ? "\n%12.6g" : " %12.6g", m[i]);
      found += number;
    }
    throw nb::value_error((name() +
                           " is not a rigid transform: its upper left block must be a rotation and "
                           "its last row 0 0 0 1; found" +
                           found)
                              .c_str());
  }
}

void CheckPoses(PosesIn X, const std::string& name) {
  for (std::size_t i = 0; i < X.shape(0); ++i) {
    CheckPose(X.data() + 16 * i, name + "[" + std::to_string(i) + "]");
  }
}

}  // namespace

void BindPoses(nb::module_& m) {
  m.def(
      "check_pose", [](PoseIn X, const char* name) { CheckPose(X.data(), name); },
      nb::arg("X").noconvert(), nb::arg("name"));
  m.def("check_poses", &CheckPoses, nb::arg("X"), nb::arg("name"));
}

}  // namespace contact_toolkit
