#include "contact/broad_phase.h"

#include <cmath>

#include "base/tolerances.h"

namespace contact_toolkit {
namespace {

// Faces along the axes of F.
struct Box {
  Vec3 center, half;
};

Box BoxInF(const ContactGeometry& geometry, const Pose& X_FB) {
  const Pose X_FG = X_FB * geometry.X_BG;
  const CollisionMesh& mesh = *geometry.mesh;
  const Vec3 half = 0.5 * (mesh.upper() - mesh.lower());
  Box box{X_FG * (0.5 * (mesh.lower() + mesh.upper())), {}};
  for (int i = 0; i < 3; ++i) {
    const Vec3& row = X_FG.R.row[i];
    box.half[i] = std::abs(row.x) * half.x + std::abs(row.y) * half.y + std::abs(row.z) * half.z;
  }
  return box;
}

bool Apart(const Box& a, const Box& b, double reach) {
  for (int i = 0; i < 3; ++i) {
    const double sum = a.half[i] + b.half[i] + reach;
    const double slack = kBoxSlack * (std::abs(a.center[i]) + std::abs(b.center[i]) + sum);
    if (std::abs(a.center[i] - b.center[i]) > sum + slack) return true;
  }
  return false;
}

}  // namespace

std::vector<int> PairsInReach(std::span<const ContactGeometry> geometries,
                              std::span<const ContactPair> pairs, std::span<const Pose> X_FB) {
  std::vector<Box> boxes;
  boxes.reserve(geometries.size());
  for (const ContactGeometry& g : geometries) boxes.push_back(BoxInF(g, X_FB[g.body]));
  std::vector<int> near;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!Apart(boxes[pairs[i].a], boxes[pairs[i].b], pairs[i].web->reach())) {
      near.push_back(static_cast<int>(i));
    }
  }
  return near;
}

}  // namespace contact_toolkit
