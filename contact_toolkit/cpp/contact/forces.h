// What the springs of a whole model do at one configuration and velocity; immutable once made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "contact/loaded_springs.h"
#include "contact/stretch.h"
#include "math/relative_motion.h"
#include "math/vec.h"

namespace contact_toolkit {

// Sums over springs.
struct Energetics {
  double stored_normal = 0, stored_tangential = 0;  // [J]
  double damping_power = 0;                         // [W] lost to the damping of normal springs
  double tangential_power = 0;  // [W] taken by tangential forces: stored or lost
  double friction_power = 0;    // [W] the part of it that is lost, at a steady cone

  Energetics& operator+=(const Energetics& other) {
    stored_normal += other.stored_normal;
    stored_tangential += other.stored_tangential;
    damping_power += other.damping_power;
    tangential_power += other.tangential_power;
    friction_power += other.friction_power;
    return *this;
  }
  Energetics& operator*=(double factor) {
    stored_normal *= factor;
    stored_tangential *= factor;
    damping_power *= factor;
    tangential_power *= factor;
    friction_power *= factor;
    return *this;
  }
};

struct SpringForce {
  double rate = 0;         // [m/s] of deformation
  double normal = 0;       // [N] on A along normal_A, but for the spring's steepness
  Vec3 friction_A;         // [N] on A, in A
  bool anchored = false;   // held within the cone, or on it without having slipped
  bool moving_on = false;  // slips the way it is stretched: has neither stopped nor reversed
};

// Of B on A of a pair: about Ao, in A. What A does to B is the same with the opposite sign.
struct PairForce {
  Vec3 torque, force;
  Energetics energetics;
};

// Torque about a body's origin, and force.
struct Wrench {
  Vec3 torque, force;
};
static_assert(sizeof(Wrench) == 6 * sizeof(double));

inline constexpr std::uint64_t kUnknownState = -1;

struct Forces : std::enable_shared_from_this<Forces> {
  std::shared_ptr<const LoadedSprings> loaded;
  std::vector<Twist> V_FB;            // the body velocities, in F
  std::vector<Wrench> body_wrenches;  // about Bo, in F
  std::vector<SpringForce> springs;   // in the order of `loaded`
  std::vector<Stretch> stretches;     // likewise; of pairs with anchored friction
  std::vector<std::size_t> first;     // index into `springs` of each loaded pair i
  std::vector<PairForce> pairs;       // of each loaded pair
  Energetics energetics;
  // Of the contact state it was computed from; 0: of none. As loaded: of none that is known.
  std::uint64_t state_id = kUnknownState;

  std::span<SpringForce> SpringsOf(std::size_t i) { return {springs.data() + first[i], SizeOf(i)}; }
  std::span<const SpringForce> SpringsOf(std::size_t i) const {
    return {springs.data() + first[i], SizeOf(i)};
  }
  std::span<Stretch> StretchesOf(std::size_t i) { return {stretches.data() + first[i], SizeOf(i)}; }
  std::span<const Stretch> StretchesOf(std::size_t i) const {
    return {stretches.data() + first[i], SizeOf(i)};
  }
  std::size_t SizeOf(std::size_t i) const { return loaded->pairs[i].springs.size(); }

  // Whether they were computed at these poses and velocities, up to what is left of the momentum
  // balance when a step is solved: 1e-10 m/s, a millisecond long.
  bool AreAt(std::span<const Pose> X_FB, std::span<const Twist> V) const;

  // [W] Were the bodies to move so.
  double PowerAt(std::span<const Twist> V) const {
    double power = 0;
    for (std::size_t i = 0; i < V.size(); ++i) {
      power += Dot(body_wrenches[i].torque, V[i].w) + Dot(body_wrenches[i].force, V[i].v);
    }
    return power;
  }

  void Retire() { loaded.reset(); }
};

}  // namespace contact_toolkit
