// The fields that nodes of the area web probe, each remembering what helps with the next node.
// `Spares`: whether a node at p certainly bears no load, even `slack` [m] from there; it takes less
// work than the value. `kSteepest`: no value changes faster than this many times the way moved.
#pragma once

#include <cstdint>

#include "distance_bounds.h"
#include "near_facets.h"
#include "probed_surface.h"
#include "smooth_field.h"
#include "vec.h"

namespace contact_toolkit {

class ExactProbe {
 public:
  static constexpr bool kTellsSide = true;
  static constexpr double kSteepest = 1;

  ExactProbe(const ProbedSurface& surface, const DistanceBounds& bounds, double standoff)
      : surface_(surface), bounds_(bounds), standoff_(standoff) {}

  bool Spares(const Vec3& p, double slack) const { return bounds_.Beyond(p, 0, standoff_ + slack); }

  FieldValue operator()(std::int32_t /*node*/, const Vec3& p) {
    const FieldValue value = surface_.Probe(p, hint_);
    hint_ = value.slot;
    return value;
  }

 private:
  const ProbedSurface& surface_;
  const DistanceBounds& bounds_;
  double standoff_;
  std::int32_t hint_ = -1;
};

// Of nodes that have moved by no more than `motion` [m] since their closest facets were gathered.
class RecallingProbe {
 public:
  static constexpr bool kTellsSide = true;

  RecallingProbe(const ProbedSurface& surface, const NearFacets& facets, double motion)
      : surface_(surface), facets_(facets), motion_(motion) {}

  FieldValue operator()(std::int32_t node, const Vec3& p) {
    return surface_.Probe(p, facets_.Of(node), motion_);
  }

 private:
  const ProbedSurface& surface_;
  const NearFacets& facets_;
  double motion_;
};

class SmoothProbe {
 public:
  static constexpr bool kTellsSide = false;
  static constexpr double kSteepest = SmoothField::kSteepest;

  SmoothProbe(const SmoothField& field, const DistanceBounds& bounds, double standoff)
      : field_(field), bounds_(bounds), standoff_(standoff) {}

  bool Spares(const Vec3& p, double slack) {
    const SmoothField::Above above = field_.IsAbove(p, standoff_ + kSteepest * slack, &cursor_);
    if (above != SmoothField::Above::kUnknown) return above == SmoothField::Above::kYes;
    return bounds_.Beyond(p, 0, standoff_ + slack + SmoothField::kDeviation * field_.cell());
  }

  FieldValue operator()(std::int32_t /*node*/, const Vec3& p) { return field_.Probe(p, &cursor_); }

 private:
  const SmoothField& field_;
  const DistanceBounds& bounds_;
  double standoff_;
  SmoothField::Cursor cursor_;
};

}  // namespace contact_toolkit
