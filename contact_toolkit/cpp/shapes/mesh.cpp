#include "shapes/mesh.h"

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <tuple>

#include "base/column.h"
#include "base/tolerances.h"
#include "shapes/box_axes.h"
#include "shapes/point_numbers.h"

namespace contact_toolkit {
namespace {

std::string Short(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

std::string Describe(const char* what, std::size_t index) {
  return std::string(what) + " " + std::to_string(index);
}

// How far pseudonormals look through facets without area: enough for a few in a row, and no mesh,
// however tangled, takes long.
constexpr int kMostInARow = 8;

// The entries that visit(emit) emits, each with a number below `count`: sorted by that number, then
// by `less`. In linear time where few share a number. Visits twice.
template <typename Entry, typename Visit, typename Less>
Column<Entry> SortedByNumber(std::size_t count, const Visit& visit, const Less& less) {
  std::vector<std::size_t> place(count + 1);  // where the next of each number belongs
  visit([&](std::int32_t number, const Entry& /*entry*/) { ++place[number + 1]; });
  std::partial_sum(place.begin(), place.end(), place.begin());
  Column<Entry> sorted(place.back());
  visit([&](std::int32_t number, const Entry& entry) { sorted[place[number]++] = entry; });
  std::size_t first = 0;
  for (std::size_t number = 0; number < count; ++number) {
    std::sort(sorted.begin() + first, sorted.begin() + place[number], less);
    first = place[number];
  }
  return sorted;
}

double AngleAt(const Vec3& corner, const Vec3& a, const Vec3& b) {
  const Vec3 u = a - corner, v = b - corner;
  return std::atan2(Norm(Cross(u, v)), Dot(u, v));
}

}  // namespace

CollisionMesh::CollisionMesh(std::span<const Vec3> vertices, std::span<const Triple> faces) {
  Weld(vertices, faces);
  bvh_ = BuildBvh(vertices_, faces_, SuitableAxes(vertices_, faces_));
  BuildEdges();
  BuildNormals();
  FindDefects();
  BuildSlotFeatures();
}

void CollisionMesh::Weld(std::span<const Vec3> vertices, std::span<const Triple> faces) {
  if (faces.empty()) {
    throw MeshError("the mesh has no facet; a contact geometry needs at least one");
  }
  const auto count = static_cast<std::int64_t>(vertices.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (const std::int32_t v : faces[f]) {
      if (v < 0 || v >= count) {
        throw MeshError(Describe("facet", f) + " refers to vertex " + std::to_string(v) +
                        (count == 0 ? ", but the mesh has no vertices"
                                    : ", but the mesh has vertices 0 to " +
                                          std::to_string(count - 1) + "; indices count from 0"));
      }
    }
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (const std::int32_t v : faces[f]) {
      for (int i = 0; i < 3; ++i) {
        const double x = vertices[v][i];
        if (!(std::abs(x) <= kMaxCoordinate)) {
          const char* found = std::isnan(x) ? "NaN" : std::isinf(x) ? "infinite" : nullptr;
          throw MeshError(Describe("vertex", v) + " of " + Describe("facet", f) + " has " +
                          (found ? "a coordinate that is " + std::string(found)
                                 : "a coordinate of magnitude " + Short(std::abs(x)) +
                                       " m, beyond the limit of 1e15 m") +
                          "; remove the facet or mend the exporter");
        }
      }
    }
  }

  welded_.resize(vertices.size());
  PointNumbers numbers(&vertices_, vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) welded_[v] = numbers.Of(vertices[v]);
  faces_.reserve(faces.size());
  for (const Triple& f : faces) {
    faces_.push_back({welded_[f[0]], welded_[f[1]], welded_[f[2]]});
  }

  lower_ = upper_ = vertices_[faces_[0][0]];
  for (const Triple& f : faces_) {
    for (const std::int32_t v : f) {
      for (int i = 0; i < 3; ++i) {
        lower_[i] = std::min(lower_[i], vertices_[v][i]);
        upper_[i] = std::max(upper_[i], vertices_[v][i]);
      }
    }
  }
  if (!(diagonal() >= kMinExtent)) {
    throw MeshError("the mesh is " + Short(diagonal()) +
                    " m across, less than the limit of 1e-15 m: its facets meet in one point; "
                    "check the scale");
  }
}

void CollisionMesh::BuildEdges() {
  // Sort all half edges by their two vertices; equal runs are one edge. Facets come in the order of
  // the hierarchy, here and below: neighbours follow each other, however the mesh lists them.
  struct HalfEdge {
    Couple ends;
    std::int32_t facet, corner;
    bool Joins(std::int32_t a, std::int32_t b) const { return ends[0] == a && ends[1] == b; }
  };
  const auto visit = [&](const auto& emit) {
    for (const std::int32_t f : bvh_.slot_facet) {
      for (int k = 0; k < 3; ++k) {
        const auto [a, b] = std::minmax(faces_[f][k], faces_[f][(k + 1) % 3]);
        emit(a, HalfEdge{{a, b}, f, k});
      }
    }
  };
  const auto half_edges =
      SortedByNumber<HalfEdge>(vertices_.size(), visit, [](const HalfEdge& a, const HalfEdge& b) {
        return std::tie(a.ends[1], a.facet, a.corner) < std::tie(b.ends[1], b.facet, b.corner);
      });
  face_edges_.resize(faces_.size());
  edges_.reserve(half_edges.size() / 2);
  edge_faces_.reserve(half_edges.size() / 2);
  for (std::size_t i = 0; i < half_edges.size();) {
    const auto edge = static_cast<std::int32_t>(edges_.size());
    edges_.push_back(half_edges[i].ends);
    edge_faces_.push_back({-1, -1});
    std::size_t users = 0;
    bool same_way = false;
    const std::size_t first = i;
    const auto [low, high] = half_edges[i].ends;
    for (; i < half_edges.size() && half_edges[i].Joins(low, high); ++i, ++users) {
      face_edges_[half_edges[i].facet][half_edges[i].corner] = edge;
      if (users < 2) edge_faces_.back()[users] = half_edges[i].facet;
    }
    if (users == 2) {
      const auto starts_low = [&](const HalfEdge& h) {
        return faces_[h.facet][h.corner] == h.ends[0];
      };
      same_way = starts_low(half_edges[first]) == starts_low(half_edges[first + 1]);
    }
    const bool collapsed = edges_.back()[0] == edges_.back()[1];
    if (users == 1 && !collapsed) defects_.open_edges.push_back(edge);
    if (users > 2 && !collapsed) defects_.non_manifold_edges.push_back(edge);
    if (same_way && !collapsed) defects_.inconsistent_edges.push_back(edge);
  }
}

void CollisionMesh::BuildNormals() {
  face_normals_.resize(faces_.size());
  edge_normals_.assign(edges_.size(), Vec3{});
  vertex_normals_.assign(vertices_.size(), Vec3{});
  const Vec3 middle = 0.5 * (lower_ + upper_);
  std::vector<std::int32_t> without_width;
  for (const std::int32_t f : bvh_.slot_facet) {
    const Vec3 p[3] = {vertices_[faces_[f][0]], vertices_[faces_[f][1]], vertices_[faces_[f][2]]};
    const Vec3 n = Cross(p[1] - p[0], p[2] - p[0]);
    face_normals_[f] = Normalized(n);
    area_ += 0.5 * Norm(n);
    volume_ += Dot(p[0] - middle, n) / 6;
    if (HasNoWidth(f)) {
      without_width.push_back(f);
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      edge_normals_[face_edges_[f][k]] += face_normals_[f];
      vertex_normals_[faces_[f][k]] +=
          AngleAt(p[k], p[(k + 1) % 3], p[(k + 2) % 3]) * face_normals_[f];
    }
  }
  // On these, the surfaces on either side meet: each edge sees what lies beyond, and the vertex in
  // the middle of the longest edge the surface across that edge.
  for (const std::int32_t f : without_width) {
    const int longest = LongestEdge(f);
    for (int k = 0; k < 3; ++k) {
      edge_normals_[face_edges_[f][k]] += NormalBeyond(f, face_edges_[f][k], kMostInARow);
    }
    vertex_normals_[faces_[f][(longest + 2) % 3]] +=
        std::numbers::pi * NormalAcross(face_edges_[f][longest], f, kMostInARow);
  }
}

int CollisionMesh::LongestEdge(std::int32_t facet) const {
  const Triple& f = faces_[facet];
  int longest = 0;
  double most = -1;
  for (int k = 0; k < 3; ++k) {
    const double squared = SquaredNorm(vertices_[f[(k + 1) % 3]] - vertices_[f[k]]);
    if (squared > most) most = squared, longest = k;
  }
  return longest;
}

// Whether the corners lie on a line, to rounding: the normal then has no direction.
bool CollisionMesh::HasNoWidth(std::int32_t facet) const {
  const Triple& f = faces_[facet];
  const Vec3 a = vertices_[f[0]], u = vertices_[f[1]] - a, v = vertices_[f[2]] - a;
  const int k = LongestEdge(facet);
  const double length = Norm(vertices_[f[(k + 1) % 3]] - vertices_[f[k]]);
  const double size = std::max(Norm(lower_), Norm(upper_));
  return Norm(Cross(u, v)) <= kTouching * size * length;
}

// The normal on the other side of a facet's edge; zero where there is none.
Vec3 CollisionMesh::NormalAcross(std::int32_t edge, std::int32_t facet, int most) const {
  const auto [a, b] = edge_faces_[edge];
  const std::int32_t other = a == facet ? b : a;
  if (other < 0 || most == 0) return {};
  return HasNoWidth(other) ? NormalBeyond(other, edge, most - 1) : face_normals_[other];
}

// The normal seen from one edge of a facet without width past its other edges: the shorter two lie
// along the longest.
Vec3 CollisionMesh::NormalBeyond(std::int32_t facet, std::int32_t edge, int most) const {
  const auto& edges = face_edges_[facet];
  const int longest = LongestEdge(facet);
  if (edge != edges[longest]) return NormalAcross(edges[longest], facet, most);
  return Normalized(NormalAcross(edges[(longest + 1) % 3], facet, most) +
                    NormalAcross(edges[(longest + 2) % 3], facet, most));
}

void CollisionMesh::FindDefects() {
  std::vector<char> used(vertices_.size(), 0);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    for (const std::int32_t v : faces_[f]) used[v] = 1;
    if (face_normals_[f] == Vec3{}) {
      defects_.zero_area_facets.push_back(static_cast<std::int32_t>(f));
    }
  }
  struct Facet {
    std::int32_t lowest, middle, highest, index;  // its sorted vertices; the facet itself
    bool SameVertices(const Facet& other) const {
      return lowest == other.lowest && middle == other.middle && highest == other.highest;
    }
  };
  const auto visit = [&](const auto& emit) {
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      Triple v = faces_[f];
      std::sort(v.begin(), v.end());
      emit(v[0], Facet{v[0], v[1], v[2], static_cast<std::int32_t>(f)});
    }
  };
  const auto sorted =
      SortedByNumber<Facet>(vertices_.size(), visit, [](const Facet& a, const Facet& b) {
        return std::tie(a.middle, a.highest, a.index) < std::tie(b.middle, b.highest, b.index);
      });
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i].SameVertices(sorted[i - 1])) {
      defects_.duplicate_facets.push_back(sorted[i].index);
    }
  }
  std::sort(defects_.duplicate_facets.begin(), defects_.duplicate_facets.end());
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) defects_.unused_vertices.push_back(static_cast<std::int32_t>(v));
  }
}

void CollisionMesh::BuildSlotFeatures() {
  slot_features_.resize(faces_.size());
  for (std::size_t slot = 0; slot < faces_.size(); ++slot) {
    const Triple& v = bvh_.slot_vertices[slot];
    const std::int32_t facet = bvh_.slot_facet[slot];
    slot_features_[slot] = {v[0], v[1], v[2], 0, 0, 0, facet, facet};
    const Couple ends[3] = {{v[0], v[1]}, {v[1], v[2]}, {v[0], v[2]}};
    for (int e = 0; e < 3; ++e) {
      for (const std::int32_t edge : face_edges_[facet]) {
        const auto& [low, high] = edges_[edge];
        if (low == ends[e][0] && high == ends[e][1]) slot_features_[slot][3 + e] = edge;
      }
    }
  }
}

}  // namespace contact_toolkit
