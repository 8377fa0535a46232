#include "web/area/point_web.h"

#include <stdexcept>

#include "web/area/area_slopes.h"

namespace contact_toolkit {

PointWeb::PointWeb(bool ball_is_a, double radius, const AreaBody& other, double stiffness,
                   double standoff)
    : ball_is_a_(ball_is_a),
      radius_(radius),
      stiffness_(stiffness),
      standoff_(standoff),
      capture_depth_(0.5 * other.thickness()),
      surface_(other.surface()) {
  if (!(radius > 0)) throw std::invalid_argument("radius must be positive");
  if (!(stiffness > 0)) throw std::invalid_argument("stiffness must be positive");
  if (!(standoff >= 0)) throw std::invalid_argument("standoff must not be negative");
  if (!surface_->closed()) throw std::invalid_argument("the other body has no inside");
}

void PointWeb::FindSprings(const Pose& X_AB, SpringSet* springs) const {
  springs->clear();
  springs->num_measured = 1;
  const Vec3 p = CenterInOther(X_AB);
  const FieldValue field = surface_->Probe(p);
  const double deformation = standoff_ + radius_ - field.phi - springs->withheld;
  if (!(deformation > 0)) return;
  if (-field.phi > capture_depth_) springs->status |= kBeyondCapture;
  const Vec3 foot = p - field.phi * field.gradient, lowest = p - radius_ * field.gradient;
  springs->Resize(1);
  springs->key[0] = 0;
  springs->deformation[0] = deformation;
  springs->elastic[0] = stiffness_ * deformation;
  springs->energy[0] = 0.5 * stiffness_ * deformation * deformation;
  springs->stiffness[0] = stiffness_;
  springs->steepness[0] = 1;
  springs->multiplicity[0] = 1;
  if (ball_is_a_) {
    springs->p_AC[0] = {};
    springs->p_ACa[0] = X_AB * lowest;
    springs->p_ACb[0] = X_AB * foot;
    springs->normal_A[0] = X_AB.R * field.gradient;
  } else {
    springs->p_AC[0] = p;
    springs->p_ACa[0] = foot;
    springs->p_ACb[0] = lowest;
    springs->normal_A[0] = -field.gradient;
  }
  if (!springs->slopes.wanted) return;
  const Symmetric3 curvature = surface_->Curvature(p, field);
  const Vec3 push = -stiffness_ * springs->normal_A[0];
  springs->slopes.nodes_on_a = ball_is_a_;
  springs->slopes.bend = {ball_is_a_ ? Rotated(X_AB.R, curvature) : curvature};
  springs->slopes.elastic = {{Cross(springs->p_AC[0], push), push}};
}

double PointWeb::Clearance(const Pose& X_AB, double /*enough*/) const {
  if (surface_->solid().kind() == SolidKind::kNearlyClosed) return 0;  // its sign leaps in a hole
  return surface_->Probe(CenterInOther(X_AB)).phi - radius_ - standoff_;
}

}  // namespace contact_toolkit
