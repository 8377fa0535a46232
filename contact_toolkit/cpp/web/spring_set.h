// What a spring web finds for one pair of geometries A, B at a relative pose, before velocities are
// known: the loaded springs, in frame A. The facet web and the area web both produce it; the
// contact law, friction and the wrenches are evaluated from it in one place (contact_model).
#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "base/columns.h"
#include "math/vec.h"
#include "web/spring_slopes.h"

namespace contact_toolkit {

// The gradient of the deformation of spring i, by the position of A, is -steepness[i] normal_A[i].
// So the force of B on A at rest is elastic[i] * steepness[i] * normal_A[i], at point p_AC[i]; with
// v the velocity of A relative to B at that point, the deformation rate is -steepness normal_A · v
// and the normal force is elastic * (1 + 3/2 alpha * rate), clamped at zero unless adhesive.
struct SpringSet {
  double withheld = 0;  // [m] of deformation that is not felt: asked of the web, not cleared by it
  std::vector<std::uint64_t>
      key;  // identity between steps: feature pair (facet web), node (area web)
  std::vector<double> deformation;  // [m] delta
  std::vector<double> elastic;      // [N] k w delta^n (facet web), K I (area web)
  std::vector<double> energy;       // [J] stored
  std::vector<double> stiffness;    // [N/m] k w: what the tangential stiffness is a ratio of
  std::vector<Vec3> p_AC;           // point of application (midpoint of the witness points)
  std::vector<Vec3> normal_A;       // unit, from B towards A
  std::vector<double> steepness;    // [-] 1 in the facet web
  std::vector<Vec3> p_ACa, p_ACb;   // witness points on the two surfaces (for output and pictures)
  std::vector<std::int32_t> multiplicity;  // facet pairs behind the spring; 1 for area nodes
  int status = 0;                          // of the pair: see ContactStatus
  // Closer than the standoff (facet web); nodes probed, fewer where memory helped (area web).
  std::int64_t num_measured = 0;
  SpringSlopes slopes;  // filled where `slopes.wanted`

  // The columns: one value each makes a row.
  template <class Self>
  static auto Columns(Self& self) {
    return std::tie(self.key, self.deformation, self.elastic, self.energy, self.stiffness,
                    self.p_AC, self.normal_A, self.steepness, self.p_ACa, self.p_ACb,
                    self.multiplicity);
  }

  std::size_t size() const { return key.size(); }
  void clear();
  // What is in new rows, and in old ones, is for the caller to set.
  void Resize(std::size_t rows) { ResizeColumns(this, rows); }
};

// Bits of SpringSet::status.
enum ContactStatus : int {
  kNominal = 0,
  kBeyondCapture = 1,  // deeper than half the probed body's thickness: the direction is unreliable
  kCrossed = 2,  // an open probed surface has been passed through; of the facet web, surfaces meet
};

}  // namespace contact_toolkit
