// Where two sharp edges cross, the overlap is thin and the elastic foundation is nearly blind to
// it. A real edge has a fillet: with radius r, two crossed edges overlapping by d press on each
// other with π K r d² (n = 1), as two crossed cylinders on a foundation do. This adds that force:
// the gradient of
//   E = 2 π K r d^{n+2} / ((n + 1)(n + 2)) · W
// with W a product of wide, smooth windows that fade it out towards the ends of the edges, for
// nearly parallel edges, where the common normal leaves either edge's normal cone, and once the
// overlap is so deep that the foundation sees it.
#pragma once

#include <vector>

#include "math/sphere_tree.h"
#include "math/vec.h"
#include "shapes/sharp_edges.h"
#include "web/spring_set.h"

namespace contact_toolkit {

class EdgeFillets {
 public:
  EdgeFillets(const CollisionMesh& A, const CollisionMesh& B, double stiffness, double exponent,
              double radius);

  // Appends up to three rows for each crossing: the force, and a couple while a window is fading.
  void AddSprings(const Pose& X_AB, SpringSet* springs) const;

 private:
  void AddCrossing(std::int32_t a, std::int32_t b, const Pose& X_AB, SpringSet* springs) const;

  double stiffness_, exponent_, radius_;
  std::vector<StraightEdge> edges_a_, edges_b_;
  SphereTree tree_a_, tree_b_;
};

}  // namespace contact_toolkit
