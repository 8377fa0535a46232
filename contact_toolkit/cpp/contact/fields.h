// What is saved of the contact between bodies, type by type; see base/archive.h. What webs remember
// to be faster, and what derivatives are made of, is left out: no answer depends on it.
#pragma once

#include <tuple>

#include "base/archive.h"
#include "contact/contact_arrays.h"
#include "contact/contact_state.h"
#include "contact/forces.h"
#include "contact/loaded_springs.h"

namespace contact_toolkit {

auto Fields(Of<Vec3> auto& self) { return std::tie(self.x, self.y, self.z); }
auto Fields(Of<Mat3> auto& self) { return std::tie(self.row); }
auto Fields(Of<Pose> auto& self) { return std::tie(self.R, self.p); }
auto Fields(Of<Twist> auto& self) { return std::tie(self.w, self.v); }
auto Fields(Of<Wrench> auto& self) { return std::tie(self.torque, self.force); }

auto Fields(Of<SpringSet> auto& self) {
  return std::tuple_cat(std::tie(self.withheld, self.status, self.num_measured),
                        SpringSet::Columns(self));
}
auto Fields(Of<PairSprings> auto& self) {
  return std::tie(self.pair, self.X_FA, self.X_AB, self.springs);
}
auto Fields(Of<LoadedSprings> auto& self) {
  return std::tuple_cat(std::tie(self.model_id, self.X_FB, self.num_springs),
                        std::tuple(InUse{self.pairs, self.size}));
}

auto Fields(Of<Energetics> auto& self) {
  return std::tie(self.stored_normal, self.stored_tangential, self.damping_power,
                  self.tangential_power, self.friction_power);
}
auto Fields(Of<SpringForce> auto& self) {
  return std::tie(self.rate, self.normal, self.friction_A, self.anchored, self.moving_on);
}
auto Fields(Of<Stretch> auto& self) { return std::tie(self.stretch_A, self.sliding, self.anchor); }
auto Fields(Of<PairForce> auto& self) { return std::tie(self.torque, self.force, self.energetics); }
// The state that they are of is named anew in each process.
auto Fields(Of<Forces> auto& self) {
  return std::tie(self.loaded, self.V_FB, self.body_wrenches, self.springs, self.stretches,
                  self.first, self.pairs, self.energetics);
}

auto Fields(Of<Easing> auto& self) { return std::tie(self.start, self.duration, self.depth); }
auto Fields(Of<Anchor> auto& self) {
  return std::tie(self.key, self.p_AQ, self.p_BQ, self.stiffness, self.sliding);
}
auto Fields(Of<PairState> auto& self) { return std::tie(self.pair, self.anchors); }
auto Fields(Of<ContactState> auto& self) {
  return std::tie(self.model_id, self.time, self.forces, self.pairs, self.easing, self.damping_loss,
                  self.friction_loss, self.numerical_loss);
}

auto Fields(Of<ContactArrays> auto& self) {
  return std::tie(self.pair, self.key, self.p_FC, self.p_FCa, self.p_FCb, self.normal_F,
                  self.deformation, self.rate, self.stiffness, self.normal_force,
                  self.friction_force_F, self.multiplicity, self.anchored, self.status);
}

}  // namespace contact_toolkit
