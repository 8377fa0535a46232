// The axes along which a hierarchy's boxes lie. A part is rarely drawn along its file's axes: a
// gear baked in at an angle, with boxes along the file's, makes forty times as many box tests.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "math/vec.h"

namespace contact_toolkit {

// Axes (rows, in the mesh's frame) along which the facets' boxes are about as small as they get:
// the best of those given by directions that many long edges, or much of the surface, have in
// common. The mesh's own where others gain little. The same for the same mesh, whatever the
// machine.
Mat3 SuitableAxes(std::span<const Vec3> vertices,
                  std::span<const std::array<std::int32_t, 3>> faces);

}  // namespace contact_toolkit
