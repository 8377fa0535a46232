// How the springs of a pair change, to first order, when A is displaced a little relative to B:
// what a web adds to its springs when it is asked. B is held; positions are taken from Ao, which
// moves along; everything is expressed in the axes of A before the displacement. See Slope.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "math/mat6.h"
#include "math/vec.h"

namespace contact_toolkit {

// A symmetric matrix: xx, yy, zz, xy, xz, yz.
using Symmetric3 = std::array<double, 6>;

inline Vec3 operator*(const Symmetric3& m, const Vec3& a) {
  return {m[0] * a.x + m[3] * a.y + m[4] * a.z, m[3] * a.x + m[1] * a.y + m[5] * a.z,
          m[4] * a.x + m[5] * a.y + m[2] * a.z};
}

struct FreeSlopes {
  VectorSlope point{};     // of p_AC
  VectorSlope gradient{};  // of steepness · normal_A [1/m]
  Slope deformation, stiffness;
};

// Rows are those of the SpringSet. The first ones may be nodes, points fixed in one of the bodies
// that probe the other's field; the rest are free.
struct SpringSlopes {
  bool wanted = false;           // set by who asks; nothing below means anything unless it is
  std::vector<Slope> elastic;    // of each row's elastic force
  bool nodes_on_a = true;        // which body the nodes are fixed in
  std::vector<Symmetric3> bend;  // of each node: what a displacement of A at the node, relative to
                                 // the node's own body, adds to steepness · normal_A [1/m]
  std::vector<FreeSlopes> free;  // of each row after the nodes

  std::size_t num_nodes() const { return bend.size(); }
  void clear() {
    elastic.clear();
    bend.clear();
    free.clear();
  }
};

}  // namespace contact_toolkit
