// Meshes fixed to bodies, and which of them may touch by what law.
#pragma once

#include <memory>

#include "contact_law.h"
#include "friction.h"
#include "mesh.h"
#include "spring_web.h"
#include "vec.h"

namespace contact_toolkit {

struct ContactGeometry {
  std::shared_ptr<const CollisionMesh> mesh;
  int body;
  Pose X_BG;
};

struct ContactPair {
  int a, b;  // geometries, on different bodies
  std::shared_ptr<const SpringWeb> web;
  ContactLaw law;
  Friction friction;
};

}  // namespace contact_toolkit
