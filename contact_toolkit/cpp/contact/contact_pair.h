// Meshes fixed to bodies, and which of them may touch by what law.
#pragma once

#include <memory>
#include <string>

#include "contact/contact_law.h"
#include "contact/friction.h"
#include "math/vec.h"
#include "shapes/mesh.h"
#include "web/spring_web.h"

namespace contact_toolkit {

struct ContactGeometry {
  std::string name;  // for messages
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
