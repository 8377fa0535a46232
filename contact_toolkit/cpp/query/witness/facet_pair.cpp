#include "query/witness/facet_pair.h"

#include <algorithm>
#include <cmath>

#include "base/scratch.h"
#include "base/tolerances.h"
#include "kernels/lanes.h"

namespace contact_toolkit {
namespace {

// Chunks after one whose guesses have failed.
constexpr int kUnguessed = 16;

constexpr int kBase[3] = {0, 1, 0}, kEnd[3] = {1, 2, 2};

Feature FeatureAt(const CollisionMesh& mesh, int slot, int spot) {
  constexpr FeatureKind kKinds[] = {
      FeatureKind::kVertex, FeatureKind::kVertex, FeatureKind::kVertex, FeatureKind::kEdge,
      FeatureKind::kEdge,   FeatureKind::kEdge,   FeatureKind::kFacet,  FeatureKind::kFacet};
  return {kKinds[spot], mesh.slot_features()[slot][spot]};
}

template <class T>
struct Corners {
  Vec<T> p[3];
};

// Adds the points where edges of P pierce the facet Q.
template <class T>
void AddPiercings(const Corners<T>& P, const Corners<T>& Q, Vec<T>* points, int* count) {
  const Vec<T> d[3] = {Q.p[1] - Q.p[0], Q.p[2] - Q.p[1], Q.p[2] - Q.p[0]};
  const Vec<T> n = Cross(d[0], d[2]);
  T h[3], w[3][3];
  for (int i = 0; i < 3; ++i) {
    h[i] = Dot(P.p[i] - Q.p[0], n);
    for (int f = 0; f < 3; ++f) {
      const Vec<T> m = f == 2 ? Cross(d[f], n) : Cross(n, d[f]);
      w[i][f] = Dot(P.p[i] - Q.p[kBase[f]], m);
    }
  }
  for (int e = 0; e < 3; ++e) {
    const int i = kBase[e], k = kEnd[e];
    if (!(h[i] * h[k] < 0)) continue;
    const T a = std::abs(h[i]), b = std::abs(h[k]);
    bool inside = true;
    for (int f = 0; f < 3; ++f) inside = inside && a * w[k][f] + b * w[i][f] >= 0;
    if (inside) points[(*count)++] = P.p[i] + (a / (a + b)) * (P.p[k] - P.p[i]);
  }
}

// The middle of the segment in which two facets cross, posed like the kernels do; false when they
// do not cross.
template <class T>
bool MiddleOfCrossing(const PosedPair& pair, const Vec3 (&p_A)[3], const Vec3 (&p_B)[3],
                      Vec3* middle) {
  Corners<T> a, b;
  const double* X = pair.matrix;
  for (int c = 0; c < 3; ++c) {
    const Vec<T> p{p_B[c].x, p_B[c].y, p_B[c].z};
    a.p[c] = {p_A[c].x, p_A[c].y, p_A[c].z};
    b.p[c] = {X[0] * p.x + X[1] * p.y + X[2] * p.z + X[9],
              X[3] * p.x + X[4] * p.y + X[5] * p.z + X[10],
              X[6] * p.x + X[7] * p.y + X[8] * p.z + X[11]};
  }
  Vec<T> points[6];
  int count = 0;
  AddPiercings(a, b, points, &count);
  AddPiercings(b, a, points, &count);
  int first = 0, second = 0;
  T longest = -1;
  for (int i = 0; i < count; ++i) {
    for (int j = i; j < count; ++j) {
      const Vec<T> apart = points[i] - points[j];
      const T length = Dot(apart, apart);
      if (length > longest) longest = length, first = i, second = j;
    }
  }
  if (count == 0) return false;
  const Vec<T> m = T(0.5) * (points[first] + points[second]);
  *middle = {static_cast<double>(m.x), static_cast<double>(m.y), static_cast<double>(m.z)};
  return true;
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
  const Vec3 p = a.Local(X_AB * b.origin);
  const Mat3 R = a.axes * (X_AB.R * Transpose(b.axes));
  float longest = 0;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      matrix[3 * i + k] = X_AB.R.row[i][k];
      cull.R[i][k] = static_cast<float>(R.row[i][k]);
      cull.abs_R[i][k] = std::abs(cull.R[i][k]);
    }
    matrix[9 + i] = X_AB.p[i] + 0.0;
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
  const double *points_a = a.slot_coordinates.data(), *points_b = b.slot_coordinates.data();
  const auto with = [&](Care care) {
    return [&, care](FacetPairs* pairs) {
      pair.kernels.facet_distances(points_a, points_b, pair.matrix, care, pairs);
    };
  };
  auto& some = Scratch<FacetPairs>([] {});
  int where[FacetPairs::kCapacity];
  const auto measure = [&](const auto& wanted, const auto& kernel) {
    some.count = 0;
    for (int k = 0; k < chunk->count; ++k) {
      if (!wanted(k)) continue;
      some.slot_a[some.count] = chunk->slot_a[k];
      some.slot_b[some.count] = chunk->slot_b[k];
      where[some.count++] = k;
    }
    if (some.count > 0) kernel(&some);
    for (int i = 0; i < some.count; ++i) chunk->CopyMeasured(where[i], some, i);
  };
  const auto doubtful = [&](int k) { return chunk->spot_a[k] >= kNeedsCare; };
  const bool any_thin = a.any_thin || b.any_thin;
  const auto thin = [&](int k) {
    return any_thin && (a.slot_thin[chunk->slot_a[k]] || b.slot_thin[chunk->slot_b[k]]);
  };
  int thin_count = 0;
  for (int k = 0; any_thin && k < chunk->count; ++k) thin_count += thin(k);
  // Where most guesses fail, as in aligned poses, the next chunks are not guessed at.
  const bool guess = chunk->unguessed == 0;
  const auto care = guess ? Care::kGuessed : Care::kFast;
  if (4 * thin_count < chunk->count) {
    with(care)(chunk);  // what is measured in vain costs less than being moved about
  } else if (thin_count < chunk->count) {
    measure([&](int k) { return !thin(k); }, with(care));
  }
  if (thin_count < chunk->count) {
    const auto again = [&](int k) { return !thin(k) && doubtful(k); };
    if (guess) {
      measure(again, with(Care::kFast));
      if (6 * some.count > chunk->count - thin_count) chunk->unguessed = kUnguessed;
    } else {
      --chunk->unguessed;
    }
    measure(again, with(Care::kCareful));
  }
  if (thin_count == 0) return;
  if (thin_count == chunk->count) {
    with(Care::kProven)(chunk);
  } else {
    measure(thin, with(Care::kProven));
  }
  measure([&](int k) { return thin(k) && doubtful(k); },
          [&](FacetPairs* pairs) { ThinFacetDistances(points_a, points_b, pair.matrix, pairs); });
}

FeaturePair FeaturesOf(const PosedPair& pair, const FacetPairs& chunk, int k) {
  return {FeatureAt(pair.A, chunk.slot_a[k], static_cast<int>(chunk.spot_a[k])),
          FeatureAt(pair.B, chunk.slot_b[k], static_cast<int>(chunk.spot_b[k]))};
}

void MendTouching(const PosedPair& pair, const FacetPairs& chunk, int k, Witness* witness) {
  const Bvh &A = pair.A.bvh(), &B = pair.B.bvh();
  const int a = chunk.slot_a[k], b = chunk.slot_b[k];
  const bool thin = A.slot_thin[a] || B.slot_thin[b];
  if (chunk.spot_a[k] == kCrossing && (thin || std::isnan(witness->p_ACa.x))) {
    Vec3 corners_a[3], corners_b[3];
    for (int c = 0; c < 3; ++c) {
      corners_a[c] = pair.A.vertices()[A.slot_vertices[a][c]];
      corners_b[c] = pair.B.vertices()[B.slot_vertices[b][c]];
    }
    // On needles with eleven bits more than double, as the point would otherwise stray from the
    // facets; in double, as the kernel did, elsewhere and where rounding alone made them cross.
    if (!thin || !MiddleOfCrossing<long double>(pair, corners_a, corners_b, &witness->p_ACa)) {
      MiddleOfCrossing<double>(pair, corners_a, corners_b, &witness->p_ACa);
    }
    witness->p_ACb = witness->p_ACa;
  }
  witness->normal_A = NormalByWinding(pair, A.slot_facet[a], B.slot_facet[b]);
}

}  // namespace contact_toolkit
