#include "web/area/edge_fillets.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "web/area/edge_crossing.h"
#include "web/area/fillet_slopes.h"

namespace contact_toolkit {
namespace {

struct Crossing {
  Dual energy;
  double outwards = 0, depth = 0;
  Vec3 p_a, p_b;  // closest points of the two lines
};

double SegmentToPoint(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 u = b - a;
  const double t = std::clamp(Dot(p - a, u) / SquaredNorm(u), 0.0, 1.0);
  return Norm(p - a - t * u);
}

SphereTree TreeOver(const std::vector<StraightEdge>& edges) {
  std::vector<Sphere> spheres;
  for (const StraightEdge& edge : edges) {
    const Vec3 middle = 0.5 * (edge.ends[0] + edge.ends[1]);
    spheres.push_back({middle, Norm(edge.ends[1] - middle)});
  }
  return SphereTree(std::move(spheres));
}

// E without its constant factor; zero unless the edges cross. `b` is already in A.
Crossing Evaluate(const StraightEdge& a, const StraightEdge& b, double r, double exponent) {
  Crossing none;
  const double length_a = Norm(a.ends[1] - a.ends[0]), length_b = Norm(b.ends[1] - b.ends[0]);
  const Vec3 along_a = (a.ends[1] - a.ends[0]) / length_a;
  const Vec3 along_b = (b.ends[1] - b.ends[0]) / length_b;
  // All of it once in plain numbers, to leave before the derivatives.
  const Vec3 across = Cross(along_a, along_b);
  const double sine2 = SquaredNorm(across);
  if (sine2 < 1e-6 * kParallelWindow) return none;
  const double outwards = Dot(across, a.into[0] + a.into[1]) < 0 ? 1 : -1;
  const Vec3 between = b.ends[0] - a.ends[0];
  const double s = Dot(Cross(between, along_b), across) / sine2;
  const double t = Dot(Cross(between, along_a), across) / sine2;
  const double depth = -outwards * Dot(between, across) / std::sqrt(sine2);
  if (!(depth > 0 && depth < kDepthGone * r && s > 0 && s < length_a && t > 0 && t < length_b)) {
    return none;
  }
  for (int i = 0; i < 2; ++i) {
    if (outwards * Dot(across, a.into[i]) >= 0 || outwards * Dot(across, b.into[i]) <= 0) {
      return none;
    }
  }

  const EdgeLine line_a{a.ends[0], along_a, length_a, a.into};
  const MovingEdge<double> moving_b = EdgeAt(b);
  return {CrossingEnergy(line_a, moving_b, outwards, r, exponent).energy, outwards, depth,
          a.ends[0] + s * along_a, b.ends[0] + t * along_b};
}

void AddRow(std::uint64_t key, double depth, double energy, double stiffness, const Vec3& force,
            const Vec3& p, const Crossing& at, SpringSet* springs) {
  const double size = Norm(force);
  springs->key.push_back(key);
  springs->deformation.push_back(depth);
  springs->elastic.push_back(size);
  springs->energy.push_back(energy);
  springs->stiffness.push_back(stiffness);
  springs->p_AC.push_back(p);
  springs->normal_A.push_back(Normalized(force));
  springs->steepness.push_back(1);
  springs->p_ACa.push_back(at.p_a);
  springs->p_ACb.push_back(at.p_b);
  springs->multiplicity.push_back(1);
}

}  // namespace

EdgeFillets::EdgeFillets(const CollisionMesh& A, const CollisionMesh& B, double stiffness,
                         double exponent, double radius)
    : stiffness_(stiffness),
      exponent_(exponent),
      radius_(radius),
      edges_a_(JoinSharpEdges(A)),
      edges_b_(JoinSharpEdges(B)),
      tree_a_(TreeOver(edges_a_)),
      tree_b_(TreeOver(edges_b_)) {}

void EdgeFillets::AddSprings(const Pose& X_AB, SpringSet* springs) const {
  if (edges_a_.empty() || edges_b_.empty()) return;
  const Pose X_BA = Inverse(X_AB);
  const Sphere& all_b = tree_b_.root();
  const double reach = kDepthGone * radius_;
  const auto near_b = [&](const Sphere& sphere) {
    return Norm(X_BA * sphere.center - all_b.center) < sphere.radius + all_b.radius + reach;
  };
  tree_a_.ForEach(near_b, [&](std::int32_t a) {
    const Vec3 start = X_BA * edges_a_[a].ends[0], end = X_BA * edges_a_[a].ends[1];
    const auto near_edge = [&](const Sphere& sphere) {
      return SegmentToPoint(start, end, sphere.center) < sphere.radius + reach;
    };
    tree_b_.ForEach(near_edge, [&](std::int32_t b) { AddCrossing(a, b, X_AB, springs); });
  });
}

void EdgeFillets::AddCrossing(std::int32_t a, std::int32_t b, const Pose& X_AB,
                              SpringSet* springs) const {
  const StraightEdge& edge = edges_b_[b];
  const StraightEdge edge_A{{X_AB * edge.ends[0], X_AB * edge.ends[1]},
                            {X_AB.R * edge.into[0], X_AB.R * edge.into[1]}};
  const Crossing at = Evaluate(edges_a_[a], edge_A, radius_, exponent_);
  if (!(at.energy.value > 0)) return;
  const double factor =
      2 * std::numbers::pi * stiffness_ * radius_ / ((exponent_ + 1) * (exponent_ + 2));
  const auto& g = at.energy.slope;
  // The force on B is minus the derivative, that on A the opposite.
  const Vec3 force = factor * Vec3{g[0], g[1], g[2]};
  const Vec3 moment = factor * Vec3{g[3], g[4], g[5]};
  const Vec3 p = 0.5 * (at.p_a + at.p_b);
  const std::uint64_t pair = static_cast<std::uint64_t>(a) * edges_b_.size() + b;
  const std::uint64_t key = std::uint64_t{1} << 63 | pair << 2;
  AddRow(key, at.depth, factor * at.energy.value, Norm(force) / at.depth, force, p, at, springs);
  const Vec3 couple = moment - Cross(p, force);
  const bool fading = Norm(couple) > 1e-12 * radius_ * Norm(force);
  if (springs->slopes.wanted) {
    AddCrossingSlopes(edges_a_[a], edge_A, at.outwards, radius_, exponent_, factor, fading,
                      &springs->slopes);
  }
  if (!fading) return;
  // Two opposite forces, an arm apart; no stiffness, so they carry no friction of their own.
  const Vec3 axis = Normalized(couple);
  const Vec3 arm = radius_ * Normalized(Cross(axis, AxisAcross(axis)));
  const Vec3 push = Cross(couple, arm) / (2 * SquaredNorm(arm));
  AddRow(key | 1, at.depth, 0, 0, push, p + arm, at, springs);
  AddRow(key | 2, at.depth, 0, 0, -push, p - arm, at, springs);
}

}  // namespace contact_toolkit
