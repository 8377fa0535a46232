#include "facet_pair.h"

#include <algorithm>
#include <cmath>

#include "tolerances.h"

namespace contact_toolkit {
namespace {

constexpr int kBase[3] = {0, 1, 0}, kEnd[3] = {1, 2, 2};

struct Corners {
  Vec3 p[3];
};

Corners CornersOf(const Bvh& bvh, int slot) {
  const double* x = &bvh.slot_coordinates[9 * static_cast<std::size_t>(slot)];
  return {{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}, {x[6], x[7], x[8]}}};
}

Corners CornersInA(const PosedPair& pair, int slot) {
  Corners b = CornersOf(pair.B.bvh(), slot);
  for (Vec3& p : b.p) p = pair.X_AB * p;
  return b;
}

Feature Corner(const CollisionMesh& mesh, int slot, int corner) {
  return {FeatureKind::kVertex, mesh.bvh().slot_vertices[slot][corner]};
}

Feature OnEdge(const CollisionMesh& mesh, int slot, int edge, double s) {
  if (s <= kOnFeature) return Corner(mesh, slot, kBase[edge]);
  if (s >= 1 - kOnFeature) return Corner(mesh, slot, kEnd[edge]);
  return {FeatureKind::kEdge, mesh.slot_edges()[slot][edge]};
}

// The feature under the foot of point p on the facet's plane, p being over its inside.
Feature UnderPoint(const CollisionMesh& mesh, int slot, const Corners& c, const Vec3& p) {
  const Vec3 d0 = c.p[1] - c.p[0], d2 = c.p[2] - c.p[0], r = p - c.p[0];
  const Vec3 n = Cross(d0, d2);
  const double nn = SquaredNorm(n);
  const double w1 = Dot(Cross(r, d2), n) / nn, w2 = Dot(Cross(d0, r), n) / nn;
  const double w[3] = {1 - w1 - w2, w1, w2};
  for (int k = 0; k < 3; ++k) {
    if (w[k] >= 1 - kOnFeature) return Corner(mesh, slot, k);
  }
  // Edge opposite corner 0 is edge 1, opposite 1 is 2, opposite 2 is 0.
  for (int k = 0; k < 3; ++k) {
    if (w[k] <= kOnFeature) return {FeatureKind::kEdge, mesh.slot_edges()[slot][(k + 1) % 3]};
  }
  return {FeatureKind::kFacet, mesh.bvh().slot_facet[slot]};
}

Vec3 Inside(const Corners& c, double u, double w) {
  return c.p[0] + u * (c.p[1] - c.p[0]) + w * (c.p[2] - c.p[0]);
}

// On an edge; its ends exactly.
Vec3 Along(const Corners& c, int edge, double s) {
  const Vec3 &a = c.p[kBase[edge]], &b = c.p[kEnd[edge]];
  return s <= 0 ? a : s >= 1 ? b : a + s * (b - a);
}

// Adds the points where edges of P pierce the facet Q.
void AddPiercings(const Corners& P, const Corners& Q, Vec3* points, int* count) {
  const Vec3 d[3] = {Q.p[1] - Q.p[0], Q.p[2] - Q.p[1], Q.p[2] - Q.p[0]};
  const Vec3 n = Cross(d[0], d[2]);
  double h[3], w[3][3];
  for (int i = 0; i < 3; ++i) {
    h[i] = Dot(P.p[i] - Q.p[0], n);
    for (int f = 0; f < 3; ++f) {
      const Vec3 m = f == 2 ? Cross(d[f], n) : Cross(n, d[f]);
      w[i][f] = Dot(P.p[i] - Q.p[kBase[f]], m);
    }
  }
  for (int e = 0; e < 3; ++e) {
    const int i = kBase[e], k = kEnd[e];
    if (!(h[i] * h[k] < 0)) continue;
    const double a = std::abs(h[i]), b = std::abs(h[k]);
    bool inside = true;
    for (int f = 0; f < 3; ++f) inside = inside && a * w[k][f] + b * w[i][f] >= 0;
    if (inside) points[(*count)++] = P.p[i] + a / (a + b) * (P.p[k] - P.p[i]);
  }
}

// The middle of the segment in which two crossing facets meet.
Vec3 MiddleOfCrossing(const Corners& a, const Corners& b) {
  Vec3 points[6];
  int count = 0;
  AddPiercings(a, b, points, &count);
  AddPiercings(b, a, points, &count);
  int first = 0, second = 0;
  double longest = -1;
  for (int i = 0; i < count; ++i) {
    for (int j = i; j < count; ++j) {
      const double length = SquaredNorm(points[i] - points[j]);
      if (length > longest) longest = length, first = i, second = j;
    }
  }
  return count > 0 ? 0.5 * (points[first] + points[second]) : a.p[0];
}

// Where distances are too small to give a direction: out of B and into A, by the facets' windings.
Vec3 NormalByWinding(const PosedPair& pair, int facet_a, int facet_b) {
  const Vec3 n_a = pair.A.face_normals()[facet_a];
  const Vec3 n_b = pair.X_AB.R * pair.B.face_normals()[facet_b];
  Vec3 n = n_b - n_a;
  if (SquaredNorm(n) < 1e-12) n = n_b;
  n = Normalized(n);
  return n == Vec3{} ? Vec3{0, 0, 1} : n;
}

}  // namespace

PosedPair::PosedPair(const CollisionMesh& A, const CollisionMesh& B, const Pose& X_AB)
    : A(A), B(B), X_AB(X_AB) {
  const Bvh &a = A.bvh(), &b = B.bvh();
  const Vec3 p = X_AB * b.origin - a.origin;
  float longest = 0;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      matrix[3 * i + k] = X_AB.R.row[i][k];
      cull.R[i][k] = static_cast<float>(X_AB.R.row[i][k]);
      cull.abs_R[i][k] = std::abs(cull.R[i][k]);
    }
    matrix[9 + i] = X_AB.p[i];
    cull.p[i] = static_cast<float>(p[i]);
    longest = std::max(longest, std::abs(cull.p[i]));
  }
  cull.slack = static_cast<float>(kCullingSlack * (a.size + b.size + longest));
  const auto reach = [](const Bvh& bvh) {
    return std::max({std::abs(bvh.origin.x), std::abs(bvh.origin.y), std::abs(bvh.origin.z)}) +
           bvh.size;
  };
  size = std::max(reach(a), reach(b) + Norm(X_AB.p));
}

void MeasureFacetPairs(const PosedPair& pair, FacetPairs* chunk) {
  if (chunk->count == 0) return;
  const Bvh &a = pair.A.bvh(), &b = pair.B.bvh();
  const auto measure = [&](bool careful, FacetPairs* pairs) {
    pair.kernels.facet_distances(a.slot_coordinates.data(), b.slot_coordinates.data(), pair.matrix,
                                 careful, pairs);
  };
  measure(false, chunk);
  thread_local FacetPairs again;
  thread_local int where[FacetPairs::kCapacity];
  again.count = 0;
  for (int k = 0; k < chunk->count; ++k) {
    const int slot_a = chunk->slot_a[k], slot_b = chunk->slot_b[k];
    if (chunk->code[k] < kNeedsCare && !a.slot_thin[slot_a] && !b.slot_thin[slot_b]) continue;
    again.slot_a[again.count] = slot_a;
    again.slot_b[again.count] = slot_b;
    where[again.count++] = k;
  }
  if (again.count == 0) return;
  measure(true, &again);
  for (int i = 0; i < again.count; ++i) {
    const int k = where[i];
    chunk->squared_distance[k] = again.squared_distance[i];
    chunk->s[k] = again.s[i];
    chunk->t[k] = again.t[i];
    chunk->code[k] = again.code[i];
  }
}

FeaturePair FeaturesOf(const PosedPair& pair, const FacetPairs& chunk, int k) {
  const CollisionMesh &A = pair.A, &B = pair.B;
  const int a = chunk.slot_a[k], b = chunk.slot_b[k], code = static_cast<int>(chunk.code[k]);
  const double s = chunk.s[k], t = chunk.t[k];
  if (code < kCornerEdge) return {OnEdge(A, a, code / 3, s), OnEdge(B, b, code % 3, t)};
  if (code < kEdgeCorner) {
    const int c = code - kCornerEdge;
    return {Corner(A, a, c / 3), OnEdge(B, b, c % 3, t)};
  }
  if (code < kCornerFacet) {
    const int c = code - kEdgeCorner;
    return {OnEdge(A, a, c % 3, s), Corner(B, b, c / 3)};
  }
  if (code == kCrossing) {
    return {{FeatureKind::kFacet, A.bvh().slot_facet[a]},
            {FeatureKind::kFacet, B.bvh().slot_facet[b]}};
  }
  const int corner = (code - kCornerFacet) % 3;
  const bool of_a = (code - kCornerFacet) / 3 % 2 == 0;
  const Corners ca = CornersOf(A.bvh(), a), cb = CornersInA(pair, b);
  return of_a ? FeaturePair{Corner(A, a, corner), UnderPoint(B, b, cb, ca.p[corner])}
              : FeaturePair{UnderPoint(A, a, ca, cb.p[corner]), Corner(B, b, corner)};
}

Witness WitnessOf(const PosedPair& pair, const FacetPairs& chunk, int k) {
  const int a = chunk.slot_a[k], b = chunk.slot_b[k], code = static_cast<int>(chunk.code[k]);
  const double s = chunk.s[k], t = chunk.t[k];
  const Corners ca = CornersOf(pair.A.bvh(), a), cb = CornersInA(pair, b);
  Witness w;
  if (code < kCornerEdge) {
    w.p_ACa = Along(ca, code / 3, s);
    w.p_ACb = Along(cb, code % 3, t);
  } else if (code < kEdgeCorner) {
    w.p_ACa = ca.p[(code - kCornerEdge) / 3];
    w.p_ACb = Along(cb, (code - kCornerEdge) % 3, t);
  } else if (code < kCornerFacet) {
    w.p_ACa = Along(ca, (code - kEdgeCorner) % 3, s);
    w.p_ACb = cb.p[(code - kEdgeCorner) / 3];
  } else if (code < kFacetCorner) {
    w.p_ACa = ca.p[code - kCornerFacet];
    w.p_ACb = w.p_ACa - t * Cross(cb.p[1] - cb.p[0], cb.p[2] - cb.p[0]);
  } else if (code < kCornerInside) {
    w.p_ACb = cb.p[code - kFacetCorner];
    w.p_ACa = w.p_ACb - s * Cross(ca.p[1] - ca.p[0], ca.p[2] - ca.p[0]);
  } else if (code < kInsideCorner) {
    w.p_ACa = ca.p[code - kCornerInside];
    w.p_ACb = Inside(cb, s, t);
  } else if (code < kCrossing) {
    w.p_ACa = Inside(ca, s, t);
    w.p_ACb = cb.p[code - kInsideCorner];
  } else {
    w.p_ACa = w.p_ACb = MiddleOfCrossing(ca, cb);
  }
  const Vec3 d = w.p_ACa - w.p_ACb;
  w.distance = Norm(d);
  w.normal_A = w.distance > kTouching * pair.size
                   ? d / w.distance
                   : NormalByWinding(pair, pair.A.bvh().slot_facet[a], pair.B.bvh().slot_facet[b]);
  return w;
}

}  // namespace contact_toolkit
