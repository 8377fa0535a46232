#include "query/swept/gjk.h"

#include <algorithm>
#include <cmath>

#include "base/tolerances.h"

namespace contact_toolkit {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// Points of the difference A − B with the indices they come from. The newest is the last.
struct Simplex {
  int count = 0;
  std::array<Vec3, 4> point;
  std::array<int, 4> a, b;
  std::array<double, 4> weight;

  void Push(const Vec3& w, int index_a, int index_b) {
    point[count] = w, a[count] = index_a, b[count] = index_b;
    ++count;
  }
  bool Contains(int index_a, int index_b) const {
    for (int i = 0; i < count; ++i) {
      if (a[i] == index_a && b[i] == index_b) return true;
    }
    return false;
  }
};

// Whether the tetrahedron contains the origin beyond rounding; sets its weights.
bool Encloses(Simplex* s) {
  const Vec3& p = s->point[3];
  const Vec3 e0 = s->point[0] - p, e1 = s->point[1] - p, e2 = s->point[2] - p;
  const Vec3 c12 = Cross(e1, e2), c20 = Cross(e2, e0), c01 = Cross(e0, e1);
  const double volume = Dot(e0, c12);
  const double size = std::max({SquaredNorm(e0), SquaredNorm(e1), SquaredNorm(e2)});
  if (!(std::abs(volume) > kFlatTetrahedron * size * std::sqrt(size))) return false;
  // Again from where the last pass arrived: a flat tetrahedron magnifies rounding, and the points
  // of A and B that the weights stand for must be the same.
  double w0 = 0, w1 = 0, w2 = 0;
  for (int pass = 0; pass < kWeightPasses; ++pass) {
    const Vec3 miss = p + w0 * e0 + w1 * e1 + w2 * e2;
    w0 -= Dot(miss, c12) / volume, w1 -= Dot(miss, c20) / volume, w2 -= Dot(miss, c01) / volume;
  }
  const double w3 = 1 - w0 - w1 - w2;
  if (!(w0 >= 0 && w1 >= 0 && w2 >= 0 && w3 >= 0)) return false;
  s->weight = {w0, w1, w2, w3};
  return true;
}

// Moves *v to the point of the simplex nearest the origin and reduces the simplex to the part that
// carries it. Leaves both alone and returns false when rounding lets nothing be gained.
bool Reduce(Simplex* s, Vec3* v) {
  const int newest = --s->count;
  const Vec3 p = s->point[newest];
  const int index_a = s->a[newest], index_b = s->b[newest];
  double least = SquaredNorm(*v);
  bool gained = false;
  // The best sub-simplex: the newest point with `others` of the older ones.
  int others = 0, first = 0, second = 0;
  double w_first = 0, w_second = 0;
  const auto offer = [&](const Vec3& x, int n, int i, int j, double w_i, double w_j) {
    const double squared = SquaredNorm(x);
    if (!(squared < least)) return;
    least = squared, *v = x, gained = true;
    others = n, first = i, second = j, w_first = w_i, w_second = w_j;
  };
  offer(p, 0, 0, 0, 0, 0);
  for (int i = 0; i < newest; ++i) {
    const Vec3 e = s->point[i] - p;
    const double t = -Dot(p, e), length = SquaredNorm(e);
    if (t > 0 && t < length) offer(p + (t / length) * e, 1, i, 0, t / length, 0);
  }
  for (int i = 0; i < newest; ++i) {
    for (int j = i + 1; j < newest; ++j) {
      const Vec3 ei = s->point[i] - p, ej = s->point[j] - p;
      const Vec3 n = Cross(ei, ej);
      const double nn = SquaredNorm(n);
      double wi = Dot(n, Cross(ej, p)) / nn, wj = Dot(n, Cross(p, ei)) / nn;
      if (!(wi > 0 && wj > 0 && wi + wj < 1)) continue;
      Vec3 x = p + wi * ei + wj * ej;
      if (nn < kNearlyParallel * SquaredNorm(ei) * SquaredNorm(ej)) {
        // A needle: the same again from close by, with less to cancel.
        const double di = Dot(n, Cross(ej, x)) / nn, dj = Dot(n, Cross(x, ei)) / nn;
        wi += di, wj += dj;
        if (!(wi > 0 && wj > 0 && wi + wj < 1)) continue;
        x = x + di * ei + dj * ej;
      }
      offer(x, 2, i, j, wi, wj);
    }
  }
  if (!gained) return false;
  s->count = 0;
  if (others > 0) s->Push(s->point[first], s->a[first], s->b[first]);
  if (others > 1) s->Push(s->point[second], s->a[second], s->b[second]);
  s->weight = {w_first, w_second};
  s->weight[others] = 1 - w_first - w_second;
  s->Push(p, index_a, index_b);
  return true;
}

// The unit vector from the origin across the simplex (of up to three points), whose nearest point
// is v. Once v is short, rounding turns it; the directions along the simplex tell better.
Vec3 Across(const Simplex& s, const Vec3& v) {
  if (s.count == 2) {
    const Vec3 e = s.point[1] - s.point[0];
    return Normalized(v - (Dot(v, e) / SquaredNorm(e)) * e);
  }
  if (s.count == 3) {
    const Vec3 n = Normalized(Cross(s.point[0] - s.point[2], s.point[1] - s.point[2]));
    return Dot(n, v) < 0 ? -n : n;
  }
  return Normalized(v);
}

// The index of the point furthest along d.
int Furthest(std::span<const Vec3> points, const Vec3& d) {
  int best = 0;
  double most = Dot(points[0], d);
  for (int i = 1; i < static_cast<int>(points.size()); ++i) {
    const double along = Dot(points[i], d);
    if (along > most) most = along, best = i;
  }
  return best;
}

double MaxNorm(const Vec3& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

class Solver {
 public:
  Solver(std::span<const Vec3> a, std::span<const Vec3> b) : a_(a), b_(b) {}

  GjkResult Run(double bound, const Vec3& guess) {
    const Support start = SupportAlong(guess);
    if (result_.lower_bound > bound) return Finish({}, GjkStatus::kBeyondBound);
    simplex_.Push(start.point, start.a, start.b);
    simplex_.weight[0] = 1;
    Vec3 v = start.point;
    for (result_.iterations = 1; result_.iterations <= kGjkIterations; ++result_.iterations) {
      const double norm = Norm(v);
      if (!(norm > Rounding())) return Finish(v, GjkStatus::kOverlapping);
      const Support w = SupportAlong(Across(simplex_, v));
      if (result_.lower_bound > bound) return Finish(v, GjkStatus::kBeyondBound);
      if (norm - w.along <= Rounding() || simplex_.Contains(w.a, w.b)) {
        return Finish(v, GjkStatus::kSeparated);
      }
      simplex_.Push(w.point, w.a, w.b);
      if (simplex_.count == 4 && Encloses(&simplex_)) return Finish({}, GjkStatus::kOverlapping);
      if (!Reduce(&simplex_, &v)) return Finish(v, GjkStatus::kSeparated);
    }
    return Finish(v, GjkStatus::kIterationLimit);
  }

 private:
  struct Support {
    Vec3 point;
    int a, b;
    double along;  // the separation the plane with this normal proves
  };

  double Rounding() const { return kGjkGap * kEpsilon * size_; }

  // The point of A − B least far along a unit vector; remembers the best separating plane.
  Support SupportAlong(const Vec3& unit) {
    const int i = Furthest(a_, -unit), j = Furthest(b_, unit);
    size_ = std::max(size_, MaxNorm(a_[i]) + MaxNorm(b_[j]));
    const Vec3 w = a_[i] - b_[j];
    const double along = Dot(unit, w);
    if (along > result_.lower_bound) result_.lower_bound = along, result_.normal = unit;
    return {w, i, j, along};
  }

  GjkResult& Finish(const Vec3& v, GjkStatus status) {
    result_.status = status;
    if (status == GjkStatus::kBeyondBound) return result_;
    result_.distance = Norm(v);
    for (int k = 0; k < simplex_.count; ++k) {
      result_.p_A += simplex_.weight[k] * a_[simplex_.a[k]];
      result_.p_B += simplex_.weight[k] * b_[simplex_.b[k]];
    }
    result_.count = simplex_.count;
    result_.index_a = simplex_.a, result_.index_b = simplex_.b, result_.weight = simplex_.weight;
    if (status == GjkStatus::kOverlapping) {
      result_.p_A = result_.p_B = 0.5 * (result_.p_A + result_.p_B);
      result_.distance = result_.lower_bound = 0;
      result_.normal = {};
    }
    result_.lower_bound = std::min(result_.lower_bound, result_.distance);
    return result_;
  }

  std::span<const Vec3> a_, b_;
  Simplex simplex_;
  double size_ = 0;  // of the coordinates met so far: the scale of rounding
  GjkResult result_;
};

}  // namespace

GjkResult Gjk(std::span<const Vec3> a, std::span<const Vec3> b, double bound, const Vec3& guess) {
  return Solver(a, b).Run(bound, guess);
}

}  // namespace contact_toolkit
