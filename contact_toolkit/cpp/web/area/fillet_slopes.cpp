#include "web/area/fillet_slopes.h"

#include "web/area/edge_crossing.h"

namespace contact_toolkit {
namespace {

Vec3 PlainOf(const DualVec3& a) { return {a.x.value, a.y.value, a.z.value}; }

Dual NormOf(const DualVec3& a) { return Sqrt(Dot(a, a)); }

DualVec3 Unit(const DualVec3& a) { return (Dual(1.0) / NormOf(a)) * a; }

// A displacement of A is the opposite one of B.
Slope SlopeOf(const Dual& a) {
  const auto& s = a.slope;
  return {{-s[3], -s[4], -s[5]}, {-s[0], -s[1], -s[2]}};
}

// Likewise; and what is known in A turns with it.
VectorSlope TurningSlopeOf(const DualVec3& a) {
  VectorSlope r;
  for (int i = 0; i < 3; ++i) {
    Vec3 axis;
    axis[i] = 1;
    const auto along = [&](int k) { return Vec3{a.x.slope[k], a.y.slope[k], a.z.slope[k]}; };
    r[i] = Cross(axis, PlainOf(a)) - along(3 + i);
    r[3 + i] = -along(i);
  }
  return r;
}

void AddRow(const DualVec3& force, const DualVec3& p, const Dual& depth, const Dual& stiffness,
            SpringSlopes* slopes) {
  slopes->elastic.push_back(SlopeOf(NormOf(force)));
  slopes->free.push_back(
      {TurningSlopeOf(p), TurningSlopeOf(Unit(force)), SlopeOf(depth), SlopeOf(stiffness)});
}

}  // namespace

void AddCrossingSlopes(const StraightEdge& a, const StraightEdge& b, double outwards, double radius,
                       double exponent, double factor, bool fading, SpringSlopes* slopes) {
  const double length = Norm(a.ends[1] - a.ends[0]);
  const EdgeLine line{a.ends[0], (a.ends[1] - a.ends[0]) / length, length, a.into};
  const MovingEdge<double> at = EdgeAt(b);
  const MovingEdge<Dual> moving{Moving(at.start, true),
                                Moving(at.along, false),
                                at.length,
                                {Moving(at.into[0], false), Moving(at.into[1], false)}};
  const CrossingValue<Dual> crossing = CrossingEnergy(line, moving, outwards, radius, exponent);
  const auto& g = crossing.energy.slope;
  const DualVec3 force = Dual(factor) * DualVec3{g[0], g[1], g[2]};
  const DualVec3 moment = Dual(factor) * DualVec3{g[3], g[4], g[5]};
  const DualVec3 p_a = Fixed<Dual>(line.start) + crossing.at_a.value * Fixed<Dual>(line.along);
  const DualVec3 p_b = moving.start + crossing.at_b.value * moving.along;
  const DualVec3 p = Dual(0.5) * (p_a + p_b);
  const Dual& depth = crossing.depth.value;
  AddRow(force, p, depth, NormOf(force) / depth, slopes);
  if (!fading) return;
  const DualVec3 couple = moment - Cross(p, force);
  const DualVec3 axis = Unit(couple);
  const DualVec3 arm = Dual(radius) * Unit(Cross(axis, Fixed<Dual>(AxisAcross(PlainOf(axis)))));
  const DualVec3 push = (Dual(0.5) / Dot(arm, arm)) * Cross(couple, arm);
  AddRow(push, p + arm, depth, 0.0, slopes);
  AddRow(Dual(-1.0) * push, p - arm, depth, 0.0, slopes);
}

}  // namespace contact_toolkit
