#include "web/area/flat_sides.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "shapes/sharp_edges.h"

namespace contact_toolkit {
namespace {

// [-] Of the mesh's size: vertices within this of a plane lie in it. Coordinates that were turned
// and rounded are off by a few roundings.
constexpr double kInPlane = 1e-13;

}  // namespace

FlatSides FindFlatSides(const CollisionMesh& mesh) {
  const auto& vertices = mesh.vertices();
  const auto& faces = mesh.faces();
  const Vec3 middle = 0.5 * (mesh.lower() + mesh.upper());
  const double far = std::max(mesh.diagonal(), Norm(middle));
  std::vector<std::int32_t> by_area(faces.size());
  std::vector<double> area(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    by_area[f] = static_cast<std::int32_t>(f);
    const auto& [a, b, c] = faces[f];
    area[f] = Norm(Cross(vertices[b] - vertices[a], vertices[c] - vertices[a]));
  }
  // Grown from the largest facets, whose planes are the most accurate.
  std::ranges::stable_sort(by_area, [&](auto f, auto g) { return area[f] > area[g]; });
  FlatSides flats;
  flats.of_facet.assign(faces.size(), -1);
  std::vector<std::int32_t> front;
  for (const std::int32_t seed : by_area) {
    if (flats.of_facet[seed] >= 0) continue;
    const auto side = static_cast<std::int32_t>(flats.sides.size());
    const Vec3 normal = mesh.face_normals()[seed];
    const double offset = Dot(normal, vertices[faces[seed][0]]);
    const auto in_plane = [&](std::int32_t facet) {
      return Dot(mesh.face_normals()[facet], normal) > 0 &&
             std::ranges::all_of(faces[facet], [&](std::int32_t v) {
               return std::abs(Dot(normal, vertices[v]) - offset) <= kInPlane * far;
             });
    };
    Vec3 lower = vertices[faces[seed][0]], upper = lower;
    flats.of_facet[seed] = side;
    front.assign(1, seed);
    while (!front.empty()) {
      const std::int32_t facet = front.back();
      front.pop_back();
      for (const std::int32_t v : faces[facet]) {
        for (int k = 0; k < 3; ++k) {
          lower[k] = std::min(lower[k], vertices[v][k]);
          upper[k] = std::max(upper[k], vertices[v][k]);
        }
      }
      for (const std::int32_t edge : mesh.face_edges()[facet]) {
        for (const std::int32_t next : mesh.edge_faces()[edge]) {
          if (next < 0 || flats.of_facet[next] >= 0 || !in_plane(next)) continue;
          flats.of_facet[next] = side;
          front.push_back(next);
        }
      }
    }
    flats.sides.push_back({normal, offset, Norm(upper - lower)});
  }
  for (std::size_t f = 0; f < faces.size(); ++f)
    flats.sides[flats.of_facet[f]].area += 0.5 * area[f];
  std::vector<char> crease(mesh.edges().size(), 0);
  for (const std::int32_t edge : FindCreases(mesh)) crease[edge] = 1;
  for (std::size_t edge = 0; edge < crease.size(); ++edge) {
    const auto [f, g] = mesh.edge_faces()[edge];
    if (g < 0 || crease[edge] || flats.of_facet[f] == flats.of_facet[g]) continue;
    flats.sides[flats.of_facet[f]].round = flats.sides[flats.of_facet[g]].round = true;
  }
  return flats;
}

std::vector<std::int32_t> FindCreasesOfFlats(const CollisionMesh& mesh) {
  const FlatSides flats = FindFlatSides(mesh);
  std::vector<std::int32_t> creases = FindCreases(mesh);
  std::erase_if(creases, [&](std::int32_t edge) {
    const auto [f, g] = mesh.edge_faces()[edge];
    return flats.sides[flats.of_facet[f]].round || flats.sides[flats.of_facet[g]].round;
  });
  return creases;
}

}  // namespace contact_toolkit
