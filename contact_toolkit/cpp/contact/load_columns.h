// How the load on a body changes with a small motion or a change of velocity, summed over points.
#pragma once

#include "math/mat6.h"
#include "math/vec.h"

namespace contact_toolkit {

// Torque and force on A, in pairs of numbers for the processor's vectors.
struct Load {
  using Pair = double __attribute__((vector_size(16)));

  Load() = default;
  Load(const Vec3& torque, const Vec3& force)
      : at{Pair{torque.x, torque.y}, Pair{torque.z, force.x}, Pair{force.y, force.z}} {}
  double operator[](int i) const { return at[i / 2][i % 2]; }
  Load& operator+=(const Load& b) {
    for (int i = 0; i < 3; ++i) at[i] += b.at[i];
    return *this;
  }

  Pair at[3] = {};
};

inline Load operator*(double s, const Load& a) {
  Load r;
  for (int i = 0; i < 3; ++i) r.at[i] = s * a.at[i];
  return r;
}
inline Load operator-(const Load& a, const Load& b) {
  Load r;
  for (int i = 0; i < 3; ++i) r.at[i] = a.at[i] - b.at[i];
  return r;
}

// A force at p.
inline Load LoadAt(const Vec3& p, const Vec3& force) { return {Cross(p, force), force}; }

// How the load changes with each component of a motion: by rotation, then by translation.
struct Columns {
  Load by[6];

  void AddOuter(const Load& load, const Slope& along) {
    by[0] += along.rotation.x * load;
    by[1] += along.rotation.y * load;
    by[2] += along.rotation.z * load;
    by[3] += along.translation.x * load;
    by[4] += along.translation.y * load;
    by[5] += along.translation.z * load;
  }

  // Given how it changes with a displacement (or velocity) of the point p along x, y and z: of a
  // rotation θ the point's share is θ × p.
  void AddAtPoint(const Vec3& p, const Load (&along)[3]) {
    by[0] += p.y * along[2] - p.z * along[1];
    by[1] += p.z * along[0] - p.x * along[2];
    by[2] += p.x * along[1] - p.y * along[0];
    for (int k = 0; k < 3; ++k) by[3 + k] += along[k];
  }
};

constexpr Vec3 kAxes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

// Forces s u at points p, for a displacement (or velocity) u of each point: sums of s over powers
// of the points' coordinates tell what all of them do to the body.
struct PointMoments {
  double sum = 0;
  Vec3 first;
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  void Add(double s, const Vec3& p) {
    const Vec3 q = s * p;
    sum += s;
    first += q;
    xx += q.x * p.x, yy += q.y * p.y, zz += q.z * p.z;
    xy += q.x * p.y, xz += q.x * p.z, yz += q.y * p.z;
  }
  Vec3 Second(const Vec3& a) const {
    return {xx * a.x + xy * a.y + xz * a.z, xy * a.x + yy * a.y + yz * a.z,
            xz * a.x + yz * a.y + zz * a.z};
  }

  // Forces s u.
  void AddTo(Columns* columns) const {
    for (int k = 0; k < 3; ++k) {
      const Vec3& axis = kAxes[k];
      columns->by[k] += Load((xx + yy + zz) * axis - Second(axis), Cross(axis, first));
      columns->by[3 + k] += Load(Cross(first, axis), sum * axis);
    }
  }
  // Forces s w × u.
  void AddCrossTo(const Vec3& w, Columns* columns) const {
    for (int k = 0; k < 3; ++k) {
      const Vec3& axis = kAxes[k];
      columns->by[k] += Load(-Cross(axis, Second(w)), Cross(w, Cross(axis, first)));
      columns->by[3 + k] += Load(Cross(first, Cross(w, axis)), sum * Cross(w, axis));
    }
  }
};

// Forces that points take along as they are displaced.
struct CarriedForces {
  Vec3 by_x, by_y, by_z;  // Σ f x, …
  Vec3 sum;

  void Add(const Vec3& p, const Vec3& force) {
    by_x += p.x * force, by_y += p.y * force, by_z += p.z * force;
    sum += force;
  }
  // The torque of what is displaced by θ × p: (θ × p) × f = p (θ · f) − θ (p · f).
  void AddTo(Columns* columns) const {
    const double trace = by_x.x + by_y.y + by_z.z;
    for (int k = 0; k < 3; ++k) {
      const Vec3 p_f{by_x[k], by_y[k], by_z[k]};
      columns->by[k] += Load(p_f - trace * kAxes[k], {});
      columns->by[3 + k] += Load(Cross(kAxes[k], sum), {});
    }
  }
};

}  // namespace contact_toolkit
