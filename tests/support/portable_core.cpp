// The kernels of every processor, where there is no Python: two bodies without a libm behind their
// coordinates, all facet pairs within a standoff, by lanes and by single numbers. `make arm` runs
// it for AArch64 and here, and the two must print the same.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "kernels/kernels.h"
#include "query/swept/swept.h"
#include "query/witness/witness.h"
#include "shapes/convex_leaves.h"

using namespace contact_toolkit;

namespace {

// A closed tube around the z axis: n × n quadrilaterals, cut in two. Rational points of circles.
CollisionMesh Ring(double radius, double tube, int n) {
  const auto circle = [n](int k) {
    const double t = -0.95 + 1.9 * (k % (n / 2)) / (n / 2);  // half of it; the rest mirrored
    const double sign = k % n < n / 2 ? 1 : -1, all = 1 + t * t;
    return std::array{sign * (1 - t * t) / all, sign * 2 * t / all};
  };
  std::vector<Vec3> vertices;
  std::vector<CollisionMesh::Triple> faces;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const auto [x, y] = circle(i);
      const auto [out, up] = circle(j);
      const double r = radius + tube * out;
      vertices.push_back({r * x, r * y, tube * up});
      const int a = i * n + j, b = i * n + (j + 1) % n;
      const int c = (i + 1) % n * n + j, d = (i + 1) % n * n + (j + 1) % n;
      faces.push_back({a, c, d});
      faces.push_back({a, d, b});
    }
  }
  return {vertices, faces};
}

void Require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "portable_core: %s\n", what);
  std::exit(1);
}

WitnessPairs Pairs(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB, double reach) {
  WitnessPairs pairs;
  FindWitnessPairs(A, B, X_AB, reach, {.merge = false, .threads = 2}, &pairs);
  return pairs;
}

// Every facet of A against every facet of B, each in a mesh of its own: no hierarchy, no batches.
std::size_t CountByBruteForce(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB,
                              double reach) {
  const auto alone = [](const CollisionMesh& mesh) {
    std::vector<CollisionMesh> facets;
    for (const auto& [i, j, k] : mesh.faces()) {
      const std::array corners{mesh.vertices()[i], mesh.vertices()[j], mesh.vertices()[k]};
      const std::array<CollisionMesh::Triple, 1> one{{{0, 1, 2}}};
      facets.emplace_back(corners, one);
    }
    return facets;
  };
  std::size_t count = 0;
  const auto of_A = alone(A), of_B = alone(B);
  for (const auto& a : of_A) {
    for (const auto& b : of_B) count += FindDistance(a, b, X_AB).distance < reach;
  }
  return count;
}

}  // namespace

int main() {
  const CollisionMesh A = Ring(0.05, 0.02, 14), B = Ring(0.06, 0.01, 12);
  constexpr double kReach = 0.004;  // [m]
  const Pose X_AB{{{Vec3{0.8, -0.6, 0}, Vec3{0.6, 0.8, 0}, Vec3{0, 0, 1}}}, {0.003, 0, 0.032}};

  SelectKernels("scalar");
  const WitnessPairs expected = Pairs(A, B, X_AB, kReach);
  Require(expected.size() == CountByBruteForce(A, B, X_AB, kReach), "pairs are missing");
  Require(expected.size() > 50, "the bodies are too far from each other to tell anything");
  Pose X_end = X_AB;
  X_end.p.z = 0.0305;
  const Motion down(X_AB, X_end);
  const SweptDistance swept = FindSweptDistance(ConvexLeaves(A), ConvexLeaves(B), down, 0);
  SelectKernels("vector");
  const WitnessPairs found = Pairs(A, B, X_AB, kReach);
  Require(found.size() == expected.size(), "another number of pairs by lanes");
  for (std::size_t row = 0; row < found.size(); ++row) {
    Require(found.distance[row] == expected.distance[row] &&
                found.p_ACa[row] == expected.p_ACa[row] && found.p_ACb[row] == expected.p_ACb[row],
            "other bits by lanes");
    std::printf("%d %d %a %a\n", found.facet_a[row], found.facet_b[row], found.distance[row],
                found.p_ACa[row].x);
  }
  Require(FindSweptDistance(ConvexLeaves(A), ConvexLeaves(B), down, 0).distance == swept.distance,
          "another swept distance by lanes");
  std::printf("%a %a\n", FindDistance(A, B, X_AB).distance, swept.distance);
}
