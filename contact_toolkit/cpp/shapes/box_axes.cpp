#include "shapes/box_axes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace contact_toolkit {
namespace {

// A fraction of the facets shows as much as all of them, and takes no longer than a tenth of the
// build.
constexpr std::size_t kShare = 16, kFewest = 64, kMost = 800;
// How many of the heaviest directions of edges, and of normals, are tried for axes; how many turns
// about each.
constexpr std::size_t kHeaviest = 3, kTurns = 6;
// [-] Other axes must make boxes this much smaller to be worth it.
constexpr double kWorthTurning = 0.9;
// [-] Cosine of the angle, about a degree, within which directions are the same.
constexpr double kTogether = 0.9998;

struct Corners {
  Vec3 p[3];
};

// Of boxes along some axes around the facets: the sum of the roots of their surfaces. It weighs
// small facets, which are where contacts are fine, more than surfaces alone would.
double BoxSizes(std::span<const Corners> facets, const Mat3& axes) {
  double sum = 0;
  for (const Corners& facet : facets) {
    double side[3];
    for (int i = 0; i < 3; ++i) {
      const Vec3& axis = axes.row[i];
      const double at[3] = {Dot(axis, facet.p[0]), Dot(axis, facet.p[1]), Dot(axis, facet.p[2])};
      side[i] = std::max({at[0], at[1], at[2]}) - std::min({at[0], at[1], at[2]});
    }
    sum += std::sqrt(side[0] * side[1] + side[1] * side[2] + side[2] * side[0]);
  }
  return sum;
}

// Lines, without a sense, that are much the same, gathered by weight.
class Directions {
 public:
  void Add(const Vec3& v, double weight) {
    const Vec3 u = Normalized(v);
    if (u == Vec3{}) return;
    for (Cluster& cluster : clusters_) {
      const double along = Dot(cluster.first, u);
      if (std::abs(along) < kTogether) continue;
      cluster.sum += (along < 0 ? -weight : weight) * u;
      cluster.weight += weight;
      return;
    }
    // Where there are many, none of the rest is heavy.
    if (clusters_.size() < kMostClusters) clusters_.push_back({u, weight * u, weight});
  }

  void AppendHeaviest(std::vector<Vec3>* axes) {
    std::ranges::stable_sort(clusters_, std::greater{}, &Cluster::weight);
    for (std::size_t i = 0; i < std::min(kHeaviest, clusters_.size()); ++i) {
      const Vec3 u = Normalized(clusters_[i].sum);
      const bool known = std::ranges::any_of(
          *axes, [&](const Vec3& axis) { return std::abs(Dot(axis, u)) > kTogether; });
      if (!known) axes->push_back(u);
    }
  }

 private:
  struct Cluster {
    Vec3 first, sum;
    double weight;
  };
  static constexpr std::size_t kMostClusters = 64;
  std::vector<Cluster> clusters_;
};

}  // namespace

Mat3 SuitableAxes(std::span<const Vec3> vertices,
                  std::span<const std::array<std::int32_t, 3>> faces) {
  const std::size_t wanted = std::clamp(faces.size() / kShare, kFewest, kMost);
  const std::size_t stride = std::max<std::size_t>(1, faces.size() / wanted);
  std::vector<Corners> sample;
  Directions edges, normals;
  for (std::size_t f = stride / 2; f < faces.size(); f += stride) {
    const Vec3 p[3] = {vertices[faces[f][0]], vertices[faces[f][1]], vertices[faces[f][2]]};
    sample.push_back({{Vec3{}, p[1] - p[0], p[2] - p[0]}});
    Vec3 longest;
    for (int k = 0; k < 3; ++k) {
      const Vec3 edge = p[(k + 1) % 3] - p[k];
      if (SquaredNorm(edge) > SquaredNorm(longest)) longest = edge;
    }
    const Vec3 n = Cross(p[1] - p[0], p[2] - p[0]);
    edges.Add(longest, SquaredNorm(longest));
    normals.Add(n, Norm(n));
  }
  std::vector<Vec3> axes;
  edges.AppendHeaviest(&axes);
  normals.AppendHeaviest(&axes);

  Mat3 best;
  double least = kWorthTurning * BoxSizes(sample, best);
  const auto offer = [&](const Vec3& x, const Vec3& about_y) {
    const Vec3 y = Normalized(about_y - Dot(about_y, x) * x);
    if (y == Vec3{}) return;
    const Mat3 candidate{{x, y, Cross(x, y)}};
    const double size = BoxSizes(sample, candidate);
    if (size < least) least = size, best = candidate;
  };
  for (const Vec3& x : axes) {
    for (const Vec3& y : axes) {
      if (std::abs(Dot(x, y)) < 0.5) offer(x, y);
    }
    const Vec3 seed = std::abs(x.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 u = Normalized(Cross(x, seed)), w = Cross(x, u);
    for (std::size_t i = 0; i < kTurns; ++i) {
      const double angle = std::numbers::pi / 2 * static_cast<double>(i) / kTurns;
      offer(x, std::cos(angle) * u + std::sin(angle) * w);
    }
  }
  return best;
}

}  // namespace contact_toolkit
