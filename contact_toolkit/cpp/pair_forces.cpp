#include "pair_forces.h"

namespace contact_toolkit {

PairForce ComputePairForce(const ContactLaw& law, const SpringSet& set, const Twist& V_A,
                           SpringForce* springs) {
  PairForce total;
  for (std::size_t i = 0; i < set.size(); ++i) {
    const Vec3& p_AC = set.p_AC[i];
    const Vec3& gradient_A = set.gradient_A[i];
    const double rate = -Dot(gradient_A, VelocityAt(V_A, p_AC));
    const double normal = law.NormalForce(set.elastic[i], rate);
    const Vec3 force = normal * gradient_A;
    total.force += force;
    total.torque += Cross(p_AC, force);
    total.energetics.stored_normal += set.energy[i];
    total.energetics.damping_power += (normal - set.elastic[i]) * rate;
    springs[i] = {rate, normal, {}, false};
  }
  return total;
}

}  // namespace contact_toolkit
