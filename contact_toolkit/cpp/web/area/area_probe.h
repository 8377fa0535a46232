// The fields that nodes of the area web probe, each remembering what helps with the next node.
// `Clearance`: of a node at p, when it may yet move by `slack` [m]; it takes less work than the
// value. `kStopsEarly`: has `IfNear`, the value, unless it is found on the way there that a node of
// such a clearance bears no load. `SafeWay`: how far a node may move [m] before its value falls by
// `above` from what it is at p. `Curvature`: second derivatives of the field [1/m] where it had a
// value.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "math/vec.h"
#include "query/point/near_facets.h"
#include "web/area/distance_bounds.h"
#include "web/area/probed_surface.h"
#include "web/area/smooth_field.h"

namespace contact_toolkit {

class ExactProbe {
 public:
  static constexpr bool kTellsSide = true, kStopsEarly = true;

  ExactProbe(const ProbedSurface& surface, const DistanceBounds& bounds, double standoff)
      : surface_(surface), bounds_(bounds), standoff_(standoff) {}

  double Clearance(const Vec3& p, double slack) const {
    const double clearance = bounds_.LowerBound(p) - standoff_;
    return clearance > slack ? clearance : std::min(clearance, 0.0);
  }

  FieldValue operator()(std::int32_t /*node*/, const Vec3& p) {
    const FieldValue value = surface_.Probe(p, hint_);
    hint_ = value.slot;
    return value;
  }

  double SafeWay(const Vec3& /*p*/, const FieldValue& /*value*/, double above) const {
    return above;
  }

  // Where the surface is farther away than the node can be deep, the node is outside.
  bool IfNear(const Vec3& p, double clearance, FieldValue* value) {
    const double deepest = surface_.closed() ? -(standoff_ + clearance) : 0.0;
    if (!surface_.ProbeWithin(p, std::max(standoff_, deepest), hint_, value)) return false;
    hint_ = value->slot;
    return true;
  }

  Symmetric3 Curvature(const Vec3& p, const FieldValue& value) const {
    return surface_.Curvature(p, value);
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
  static constexpr bool kTellsSide = true, kStopsEarly = false;

  RecallingProbe(const ProbedSurface& surface, const NearFacets& facets, double motion)
      : surface_(surface), facets_(facets), motion_(motion) {}

  FieldValue operator()(std::int32_t node, const Vec3& p) {
    if (surface_.primitive()) return surface_.Probe(p);
    return surface_.Probe(p, facets_.Of(node), motion_);
  }

  Symmetric3 Curvature(const Vec3& p, const FieldValue& value) const {
    return surface_.Curvature(p, value);
  }

 private:
  const ProbedSurface& surface_;
  const NearFacets& facets_;
  double motion_;
};

class SmoothProbe {
 public:
  static constexpr bool kTellsSide = false, kStopsEarly = false;
  SmoothProbe(const SmoothField& field, const DistanceBounds& bounds, double standoff)
      : field_(field), bounds_(bounds), standoff_(standoff) {}

  double Clearance(const Vec3& p, double slack) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    switch (field_.IsAbove(p, standoff_ + SmoothField::kSteepest * slack, &cursor_)) {
      case SmoothField::Above::kYes:
        return kInfinity;
      case SmoothField::Above::kMaybeNot:
        return -kInfinity;
      default:
        break;
    }
    const double reach = standoff_ + SmoothField::kDeviation * field_.cell();
    return bounds_.Beyond(p, 0, reach + slack) ? kInfinity : -kInfinity;
  }

  FieldValue operator()(std::int32_t /*node*/, const Vec3& p) { return field_.Probe(p, &cursor_); }

  double SafeWay(const Vec3& p, const FieldValue& value, double above) const {
    return field_.SafeWay(p, value.gradient, above);
  }

  Symmetric3 Curvature(const Vec3& p, const FieldValue& /*value*/) {
    return field_.Curvature(p, &cursor_);
  }

 private:
  const SmoothField& field_;
  const DistanceBounds& bounds_;
  double standoff_;
  SmoothField::Cursor cursor_;
};

}  // namespace contact_toolkit
