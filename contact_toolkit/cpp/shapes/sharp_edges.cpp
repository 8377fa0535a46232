#include "shapes/sharp_edges.h"

#include <cmath>
#include <numeric>
#include <unordered_map>

namespace contact_toolkit {
namespace {

constexpr double kSharpCosine = 0.866;  // of 30°
constexpr double kSamePlane = 1e-6;     // [-] between unit vectors of one straight edge

Vec3 Direction(const CollisionMesh& mesh, std::int32_t edge) {
  const auto [a, b] = mesh.edges()[edge];
  return Normalized(mesh.vertices()[b] - mesh.vertices()[a]);
}

// Unit vectors in the two facets, square to the edge.
std::array<Vec3, 2> IntoFacets(const CollisionMesh& mesh, std::int32_t edge) {
  const Vec3& start = mesh.vertices()[mesh.edges()[edge][0]];
  const Vec3 along = Direction(mesh, edge);
  std::array<Vec3, 2> into;
  for (int side = 0; side < 2; ++side) {
    const std::int32_t facet = mesh.edge_faces()[edge][side];
    into[side] = Normalized(Cross(mesh.face_normals()[facet], along));
    double reach = 0;
    for (const std::int32_t v : mesh.faces()[facet]) {
      reach += Dot(mesh.vertices()[v] - start, into[side]);
    }
    if (reach < 0) into[side] = -into[side];
  }
  return into;
}

bool Close(const Vec3& a, const Vec3& b) { return SquaredNorm(a - b) < kSamePlane * kSamePlane; }

}  // namespace

std::vector<std::int32_t> FindSharpEdges(const CollisionMesh& mesh) {
  std::vector<std::int32_t> sharp;
  for (std::size_t e = 0; e < mesh.edges().size(); ++e) {
    const auto [f, g] = mesh.edge_faces()[e];
    if (g < 0) continue;
    const Vec3 &n = mesh.face_normals()[f], &start = mesh.vertices()[mesh.edges()[e][0]];
    double height = 0;  // of the other facet over the first: below it where the edge is convex
    for (const std::int32_t v : mesh.faces()[g]) {
      const double h = Dot(mesh.vertices()[v] - start, n);
      if (std::abs(h) > std::abs(height)) height = h;
    }
    if (Dot(n, mesh.face_normals()[g]) < kSharpCosine && height < 0) {
      sharp.push_back(static_cast<std::int32_t>(e));
    }
  }
  return sharp;
}

std::vector<std::int32_t> FindCreases(const CollisionMesh& mesh) {
  std::vector<std::int32_t> creases;
  for (std::size_t e = 0; e < mesh.edges().size(); ++e) {
    const auto [f, g] = mesh.edge_faces()[e];
    if (g >= 0 && Dot(mesh.face_normals()[f], mesh.face_normals()[g]) < kSharpCosine) {
      creases.push_back(static_cast<std::int32_t>(e));
    }
  }
  return creases;
}

std::vector<std::int32_t> FindSides(const CollisionMesh& mesh) {
  std::vector<std::int32_t> side(mesh.faces().size());  // a facet of it; the one that is its own
  std::iota(side.begin(), side.end(), 0);
  const auto find = [&](std::int32_t f) {
    while (side[f] != f) f = side[f] = side[side[f]];
    return f;
  };
  std::vector<char> parts(mesh.edges().size(), 0);
  for (const std::int32_t edge : FindSharpEdges(mesh)) parts[edge] = 1;
  for (std::size_t e = 0; e < parts.size(); ++e) {
    const auto [f, g] = mesh.edge_faces()[e];
    if (g >= 0 && !parts[e]) side[find(f)] = find(g);
  }
  for (std::int32_t& s : side) s = find(s);
  return side;
}

std::vector<StraightEdge> JoinSharpEdges(const CollisionMesh& mesh) {
  const std::vector<std::int32_t> sharp = FindSharpEdges(mesh);
  std::unordered_map<std::int32_t, std::vector<std::int32_t>> at_vertex;
  for (const std::int32_t edge : sharp) {
    for (const std::int32_t v : mesh.edges()[edge]) at_vertex[v].push_back(edge);
  }
  std::vector<char> taken(mesh.edges().size(), 0);
  std::vector<StraightEdge> joined;
  for (const std::int32_t first : sharp) {
    if (taken[first]) continue;
    taken[first] = 1;
    const Vec3 along = Direction(mesh, first);
    const std::array<Vec3, 2> into = IntoFacets(mesh, first);
    StraightEdge run{{}, into};
    for (int end = 0; end < 2; ++end) {
      std::int32_t vertex = mesh.edges()[first][end];
      for (bool grown = true; grown;) {
        grown = false;
        for (const std::int32_t next : at_vertex[vertex]) {
          if (taken[next]) continue;
          const Vec3 onwards = Direction(mesh, next);
          const auto [a, b] = IntoFacets(mesh, next);
          const bool straight = Close(onwards, along) || Close(-onwards, along);
          const bool same_planes =
              (Close(a, into[0]) && Close(b, into[1])) || (Close(a, into[1]) && Close(b, into[0]));
          if (!straight || !same_planes) continue;
          taken[next] = 1;
          const auto [u, v] = mesh.edges()[next];
          vertex = u == vertex ? v : u;
          grown = true;
          break;
        }
      }
      run.ends[end] = mesh.vertices()[vertex];
    }
    joined.push_back(run);
  }
  return joined;
}

}  // namespace contact_toolkit
