#include "contact/pair_linearization.h"

#include "contact/load_columns.h"
#include "contact/spring_change.h"

namespace contact_toolkit {
namespace {

class PairSum {
 public:
  PairSum(const ContactLaw& law, const Friction& friction, const SpringSet& springs,
          const Twist& V_A, std::span<const Stretch> stretches, std::span<const SpringForce> forces,
          const StretchSources* sources, bool keep_cone)
      : law_(law),
        friction_(friction),
        springs_(springs),
        V_A_(V_A),
        stretches_(stretches),
        forces_(forces),
        sources_(sources),
        keep_cone_(keep_cone) {}

  void Run() {
    const std::size_t nodes = springs_.slopes.num_nodes();
    for (std::size_t i = 0; i < nodes; ++i) AddNode(i);
    if (nodes > 0) ReferNodesToA();
    for (std::size_t i = nodes; i < springs_.size(); ++i) AddFree(i);
  }

  Columns by_pose, by_velocity;

 private:
  SpringChange ChangeOf(std::size_t i, const Vec3& velocity) const {
    const bool anchored = friction_.anchored();
    return {law_,
            friction_,
            springs_,
            i,
            velocity,
            anchored ? &stretches_[i] : nullptr,
            anchored && sources_ ? &sources_->rows[i] : nullptr,
            forces_[i],
            keep_cone_};
  }

  Vec3 ForceOf(std::size_t i) const {
    return (springs_.steepness[i] * forces_[i].normal) * springs_.normal_A[i] +
           forces_[i].friction_A;
  }

  // A node is looked at from its own body's opposite: B for a node of A, A for a node of B. There
  // the force depends on where the node is, and on nothing else but its anchor's lever. The field
  // of velocities is held in that frame.
  void AddNode(std::size_t i) {
    const Vec3& p = springs_.p_AC[i];
    const bool on_a = springs_.slopes.nodes_on_a;
    const double way = on_a ? 1 : -1;  // of the node for that of A at the node
    const Vec3 force = ForceOf(i);
    total_.rotation += Cross(p, force), total_.translation += force;
    carried_.Add(p, way * force);
    const SpringChange change = ChangeOf(i, VelocityAt(V_A_, p));
    by_pose.AddOuter(LoadAt(p, change.by_elastic()), springs_.slopes.elastic[i]);
    const Symmetric3& bend = springs_.slopes.bend[i];
    const StretchSource* source = friction_.anchored() && sources_ ? &sources_->rows[i] : nullptr;
    const double held = source ? source->held_weight : 1.0;
    if (bend == Symmetric3{} && !(source && source->weight > 0)) {
      AddFlat(p, change, held, way);
    } else {
      AddBent(i, p, change, source, held, way);
    }
    if (source) AddLever(p, *source, on_a, change);
  }

  // A spring whose direction stays: a multiple of the displacement, and of its cross product with
  // the angular velocity, less components along two directions.
  void AddFlat(const Vec3& p, const SpringChange& change, double held, double way) {
    const auto flat = change.ByFlat(held, way, V_A_.w);
    const auto velocity = change.ByVelocity();
    const Load along_normal = LoadAt(p, change.normal());
    const auto at_p = [&p](const Vec3& a) { return Slope{Cross(p, a), a}; };
    by_pose.AddOuter(along_normal, at_p(flat.normal));
    by_velocity.AddOuter(along_normal, at_p(velocity.normal));
    if (!change.rubs()) return;
    held_.Add(flat.held, p);
    rubbed_.Add(velocity.isotropic, p);
    if (!change.slips()) return;
    const Load along = LoadAt(p, change.along());
    by_pose.AddOuter(along, at_p(flat.along));
    by_velocity.AddOuter(along, at_p(velocity.along));
  }

  void AddBent(std::size_t i, const Vec3& p, const SpringChange& change,
               const StretchSource* source, double held, double way) {
    Load columns[3];
    for (int k = 0; k < 3; ++k) {
      const Vec3& axis = kAxes[k];
      SpringChange::Direction d;
      d.gradient = springs_.slopes.bend[i] * axis;
      d.velocity = way * Cross(V_A_.w, axis);
      d.held = held * axis;
      if (source) {
        d.since = way > 0 ? axis : sources_->turned * axis;
        d.deformation = -springs_.steepness[i] * springs_.normal_A[i][k];
      }
      columns[k] = LoadAt(p, change.By(d));
    }
    by_pose.AddAtPoint(p, columns);
    AddVelocity(p, change);
  }

  void AddVelocity(const Vec3& p, const SpringChange& change) {
    const auto velocity = change.ByVelocity();
    Load columns[3];
    for (int k = 0; k < 3; ++k) {
      Vec3 force = velocity.normal[k] * change.normal() + velocity.along[k] * change.along();
      force[k] += velocity.isotropic;
      columns[k] = LoadAt(p, force);
    }
    by_velocity.AddAtPoint(p, columns);
  }

  // What is anchored elsewhere than at the node moves otherwise when the body turns.
  void AddLever(const Vec3& p, const StretchSource& source, bool on_a, const SpringChange& change) {
    Vec3 held = source.held_point - source.held_weight * p, since;
    if (!on_a) held -= source.held, since = -source.since;
    if (held == Vec3{} && since == Vec3{}) return;
    for (int k = 0; k < 3; ++k) {
      SpringChange::Direction d;
      d.held = Cross(kAxes[k], held);
      d.since = Cross(kAxes[k], since);
      by_pose.by[k] += LoadAt(p, source.weight > 0 ? change.By(d) : change.ByHeld(d.held));
    }
  }

  // From the nodes' frame to the one in which B, and the twist in A's present axes, are held.
  void ReferNodesToA() {
    const auto [torque, force] = total_;
    const double way = springs_.slopes.nodes_on_a ? 1 : -1;
    held_.AddTo(&by_pose);
    rubbed_.AddTo(&by_velocity);
    // What is rubbed moves with the node, in the field of velocities.
    rubbed_.AddCrossTo(way * V_A_.w, &by_pose);
    carried_.AddTo(&by_pose);
    Columns change = by_pose;
    const auto with_twist = [&](Load* column, const Vec3& w, const Vec3& v) {
      for (int k = 0; k < 3; ++k) {
        *column += w[k] * by_velocity.by[k];
        *column += v[k] * by_velocity.by[3 + k];
      }
    };
    for (int k = 0; k < 3; ++k) {
      const Vec3& axis = kAxes[k];
      if (springs_.slopes.nodes_on_a) {
        // A field of velocities held in space has another velocity where Ao comes to be.
        with_twist(&change.by[3 + k], {}, -Cross(V_A_.w, axis));
        change.by[3 + k] += Load(Cross(force, axis), {});
      } else {
        with_twist(&change.by[k], Cross(V_A_.w, axis), Cross(V_A_.v, axis));
        change.by[k] += Load(Cross(axis, torque), Cross(axis, force));
      }
    }
    by_pose = change;
  }

  void AddFree(std::size_t i) {
    const Vec3& p = springs_.p_AC[i];
    const FreeSlopes& slopes = springs_.slopes.free[i - springs_.slopes.num_nodes()];
    const Vec3 force = ForceOf(i);
    const SpringChange change = ChangeOf(i, VelocityAt(V_A_, p));
    const Vec3& by_elastic = change.by_elastic();
    by_pose.AddOuter(LoadAt(p, by_elastic), springs_.slopes.elastic[i]);
    const StretchSource* source = friction_.anchored() && sources_ ? &sources_->rows[i] : nullptr;
    for (int k = 0; k < 6; ++k) {
      const Vec3 rotation = k < 3 ? kAxes[k] : Vec3{}, translation = k < 3 ? Vec3{} : kAxes[k - 3];
      const auto part = [&](const Slope& slope) {
        return k < 3 ? slope.rotation[k] : slope.translation[k - 3];
      };
      const Vec3 at_p = translation + Cross(rotation, p);
      SpringChange::Direction d;
      d.gradient = slopes.gradient[k];
      d.velocity = Cross(V_A_.w, slopes.point[k]);
      d.deformation = part(slopes.deformation);
      d.stiffness = part(slopes.stiffness);
      d.held = at_p;
      if (source) {
        d.held = Cross(rotation, source->held_point) + source->held_weight * translation;
        // Where on A the point is changes too, and with it where it was.
        const Vec3 along_a = slopes.point[k] - Cross(rotation, p);
        d.since = at_p + along_a - sources_->turned * along_a;
      }
      const Vec3 changed = change.By(d);
      by_pose.by[k] += Load(Cross(p, changed) + Cross(slopes.point[k], force), changed);
    }
    AddVelocity(p, change);
  }

  const ContactLaw& law_;
  const Friction& friction_;
  const SpringSet& springs_;
  const Twist& V_A_;
  std::span<const Stretch> stretches_;
  std::span<const SpringForce> forces_;
  const StretchSources* sources_;
  bool keep_cone_;
  // Of the nodes.
  Slope total_;  // torque and force
  PointMoments held_, rubbed_;
  CarriedForces carried_;
};

Mat6 Negative(const Columns& columns, bool symmetric) {
  Mat6 m;
  for (int k = 0; k < 6; ++k) {
    for (int i = 0; i < 6; ++i) m[i][k] = -columns.by[k][i];
  }
  if (symmetric) {
    for (int i = 0; i < 6; ++i) {
      for (int k = 0; k < i; ++k) m[i][k] = m[k][i] = 0.5 * (m[i][k] + m[k][i]);
    }
  }
  return m;
}

}  // namespace

PairForce LinearizePair(const ContactLaw& law, const Friction& friction, const SpringSet& springs,
                        const Twist& V_A, std::span<const Stretch> stretches,
                        std::span<SpringForce> forces, PairLinearization* out,
                        const StretchSources* sources, Symmetry symmetry) {
  const PairForce total = ComputePairForce(law, friction, springs, V_A, stretches, forces);
  const bool symmetric = symmetry == Symmetry::kKept;
  PairSum sum(law, friction, springs, V_A, stretches, forces, sources, !symmetric);
  sum.Run();
  out->stiffness = Negative(sum.by_pose, symmetric);
  out->damping = Negative(sum.by_velocity, symmetric);
  return total;
}

}  // namespace contact_toolkit
