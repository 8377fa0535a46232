// How the force of one spring changes with what it depends on, by differentiating pair_forces line
// by line.
#pragma once

#include <cmath>

#include "contact/contact_law.h"
#include "contact/forces.h"
#include "contact/friction.h"
#include "contact/stretch.h"
#include "math/vec.h"
#include "web/spring_set.h"

namespace contact_toolkit {

class SpringChange {
 public:
  // What a spring's force depends on, by its change in one direction: steepness · normal, the
  // velocity at the point of application, the offsets that friction stretches by, and numbers. The
  // elastic force's own change is apart, see `by_elastic`.
  struct Direction {
    Vec3 gradient, velocity, held, since;
    double deformation = 0, stiffness = 0;
  };

  // `keep_cone`: whether the cone of sliding friction changes with the normal force.
  SpringChange(const ContactLaw& law, const Friction& friction, const SpringSet& springs,
               std::size_t i, const Vec3& velocity, const Stretch* stretch,
               const StretchSource* source, const SpringForce& force, bool keep_cone)
      : friction_(friction),
        normal_(springs.normal_A[i]),
        steepness_(springs.steepness[i]),
        elastic_(springs.elastic[i]),
        velocity_(velocity) {
    const double damped = 1 + law.Damping(force.rate);
    if (law.adhesion || elastic_ * damped > 0)
      factor_ = damped, damping_ = law.DampingSlope(force.rate);
    const double stiffness = springs.stiffness[i];
    by_elastic_ = factor_ * steepness_ * normal_;
    if (!friction.active() || !(steepness_ > 0) || !(stiffness > 0)) return;
    const bool sliding = stretch ? stretch->sliding : true;
    const double load = steepness_ * force.normal, limit = friction.Limit(load, sliding);
    if (!(limit > 0)) return;
    rubs_ = true;
    approach_ = -Dot(normal_, velocity);
    slip_ = velocity + approach_ * normal_;
    tangential_stiffness_ = friction.TangentialStiffness(stiffness);
    tangential_damping_ = friction.TangentialDamping(stiffness, elastic_);
    if (stretch) stretch_ = stretch->stretch_A;
    if (source && source->weight > 0) {
      new_weight_ = source->weight;
      since_ = source->since, share_ = source->share;
      partial_ = share_ < 1;
      deformation_ = springs.deformation[i];
      by_stiffness_ = (1 / stiffness) * (share_ * InPlane(since_) - stretch_);
      offset_ = source->held + (new_weight_ * share_) * since_;
    } else {
      offset_ = source ? source->held : stretch_;
    }
    lift_ = Dot(offset_, normal_);
    const Vec3 trial = -tangential_stiffness_ * stretch_ - tangential_damping_ * slip_;
    const double squared_size = SquaredNorm(trial);
    by_damping_ = friction.damping_slope * friction.stiffness_ratio;
    if (squared_size > limit * limit) {
      slips_ = true;
      const double size = std::sqrt(squared_size);
      along_ = trial / size;
      kept_ = limit / size;
      if (keep_cone) cone_ = limit / load;
    }
    by_elastic_ += (cone_ * steepness_ * factor_) * along_ + Limited(-by_damping_ * slip_);
  }

  // For an elastic force that grows by 1 N.
  const Vec3& by_elastic() const { return by_elastic_; }

  // For what else changes.
  Vec3 By(const Direction& d) const {
    const double normal_rate = Dot(d.gradient, velocity_) + steepness_ * Dot(normal_, d.velocity);
    const double grown = -elastic_ * damping_ * normal_rate;
    Vec3 change = (grown * steepness_) * normal_ + (elastic_ * factor_) * d.gradient;
    if (!rubs_) return change;
    const double steeper = Dot(normal_, d.gradient);
    const Vec3 turn = (1 / steepness_) * (d.gradient - steeper * normal_);
    const Vec3 slip = InPlane(d.velocity) - Dot(velocity_, turn) * normal_ + approach_ * turn;
    Vec3 trial = -tangential_damping_ * slip - (friction_.damping_time * d.stiffness) * slip_;
    if (tangential_stiffness_ > 0) {
      trial -= tangential_stiffness_ * StretchBy(d, turn) +
               (friction_.stiffness_ratio * d.stiffness) * stretch_;
    }
    change += Limited(trial);
    if (slips_) change += (cone_ * (steepness_ * grown + elastic_ * factor_ * steeper)) * along_;
    return change;
  }

  // The same where nothing but `held` changes.
  Vec3 ByHeld(const Vec3& held) const {
    return rubs_ ? Limited(-tangential_stiffness_ * InPlane(held)) : Vec3{};
  }

  // For a displacement u of a point whose direction stays, which is held to the share `held` and
  // carried through a field of velocities turning at w: the force changes by
  //   held u + isotropic (w × u) + (normal() ⊗ normal + along() ⊗ along) u,
  // with `isotropic` that of ByVelocity().
  struct FlatChange {
    double held = 0;
    Vec3 normal, along;
  };
  FlatChange ByFlat(double held, double way, const Vec3& w) const {
    FlatChange change;
    const Vec3 carried = way * Cross(normal_, w);  // of the velocity along the normal
    const double push = -elastic_ * damping_ * steepness_ * steepness_;
    change.normal = push * carried;
    if (!rubs_) return change;
    const double rub = -kept_ * tangential_damping_;
    change.held = -kept_ * tangential_stiffness_ * held;
    change.normal = (push - rub) * carried - change.held * normal_;
    if (slips_) {
      change.along =
          (cone_ * push) * carried - change.held * along_ - (rub * way) * Cross(along_, w);
    }
    return change;
  }

  // For a change u of velocity: the force changes by
  //   isotropic u + (normal() ⊗ normal + along() ⊗ along) u.
  struct VelocityChange {
    double isotropic = 0;
    Vec3 normal, along;
  };
  VelocityChange ByVelocity() const {
    const double push = -elastic_ * damping_ * steepness_ * steepness_;
    if (!rubs_) return {0, push * normal_, {}};
    const double rub = -kept_ * tangential_damping_;
    if (!slips_) return {rub, (push - rub) * normal_, {}};
    return {rub, (push - rub) * normal_, (cone_ * push) * normal_ - rub * along_};
  }

  bool rubs() const { return rubs_; }
  bool slips() const { return slips_; }
  const Vec3& along() const { return along_; }  // of the friction, where it slips
  const Vec3& normal() const { return normal_; }

 private:
  Vec3 InPlane(const Vec3& a) const { return a - Dot(a, normal_) * normal_; }

  // What the cone leaves of a change of the trial force.
  Vec3 Limited(const Vec3& trial) const {
    return slips_ ? kept_ * (trial - Dot(trial, along_) * along_) : trial;
  }

  Vec3 StretchBy(const Direction& d, const Vec3& turn) const {
    Vec3 offset = d.held;
    if (new_weight_ > 0) {
      offset += (new_weight_ * share_) * d.since;
      if (partial_) {
        const double approach = -Dot(since_, normal_);
        const double faster = -Dot(d.since, normal_) - Dot(since_, turn);
        const double shared = deformation_ > 0 ? (d.deformation - share_ * faster) / approach : 0.0;
        offset += (new_weight_ * shared) * since_;
      }
    }
    return InPlane(offset) - Dot(offset_, turn) * normal_ - lift_ * turn +
           d.stiffness * by_stiffness_;
  }

  const Friction& friction_;
  Vec3 normal_;
  double steepness_, elastic_;
  Vec3 velocity_;
  double factor_ = 0, damping_ = 0;  // 1 + 3/2 α rate and 3/2 α; zero where the force is clamped
  Vec3 by_elastic_;
  // Of friction.
  bool rubs_ = false, slips_ = false, partial_ = false;
  double approach_ = 0, tangential_stiffness_ = 0, tangential_damping_ = 0, by_damping_ = 0;
  double new_weight_ = 0, share_ = 1, deformation_ = 0, lift_ = 0;
  double kept_ = 1, cone_ = 0;  // of the trial force; coefficient, while it slips
  Vec3 slip_, stretch_, offset_, since_, by_stiffness_, along_;
};

}  // namespace contact_toolkit
