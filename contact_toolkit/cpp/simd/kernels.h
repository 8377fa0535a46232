// The inner loops of mesh–mesh proximity, compiled once for each instruction set and chosen at run
// time. Nothing here allocates or throws; the drivers (witness.cpp, distance.cpp) do the rest.
// All instruction sets give the same bits: the operations and their order are the same, only the
// number of lanes differs, and fused multiply-add is off.
#pragma once

#include <cstdint>

#include "bvh.h"

namespace contact_toolkit {

// The pose of B in A between the two hierarchies' origins, in single precision for culling.
struct CullPose {
  float R[3][3];
  float abs_R[3][3];
  float p[3];
  float slack;  // [m] covers all single-precision rounding
};

// How a facet pair's least distance is attained; `feature codes` of FacetPairs::code.
// Corners and edges are numbered by the sorted vertices of the slot: edge 0 = (0,1), 1 = (1,2),
// 2 = (0,2), running from the first to the second.
inline constexpr int kEdgeEdge = 0;        // + 3 e + f: at s along edge e of A, t along edge f of B
inline constexpr int kCornerEdge = 9;      // + 3 i + f: corner i of A, t along edge f of B
inline constexpr int kEdgeCorner = 18;     // + 3 j + e: s along edge e of A, corner j of B
inline constexpr int kCornerFacet = 27;    // + i: corner i of A, (1 - s - t, s, t) barycentric on B
inline constexpr int kFacetCorner = 30;    // + j: (1 - s - t, s, t) barycentric on A, corner j of B
inline constexpr int kCrossing = 33;       // an edge of one pierces the other
inline constexpr int kNeedsCare = 64;      // added by the fast kernel: ask the careful one

// A chunk of facet pairs, structure of arrays.
struct FacetPairs {
  static constexpr int kCapacity = 256;
  int count = 0;
  std::int32_t slot_a[kCapacity + kBvhWidth], slot_b[kCapacity + kBvhWidth];
  double squared_distance[kCapacity + kBvhWidth];
  double s[kCapacity + kBvhWidth], t[kCapacity + kBvhWidth];
  double code[kCapacity + kBvhWidth];
};

struct Kernels {
  const char* name;
  int lanes;  // of the facet kernel

  // Bit 8 j + k is set when child k of a and child j of b may be closer than reach [m].
  std::uint64_t (*box_pairs)(const BvhNode& a, const BvhNode& b, const CullPose& X_AB, float reach);

  // The same test, leaving lower bounds of the squared distances in bound[8 j + k].
  void (*box_bounds)(const BvhNode& a, const BvhNode& b, const CullPose& X_AB, float bound[64]);

  // Clears the bits of facet pairs that lie apart by more than reach along a facet's normal.
  std::uint64_t (*cull_by_planes)(const FacetBlock& a, const FacetBlock& b, const CullPose& X_AB,
                                  float reach, std::uint64_t pairs);

  // Least distances of all pairs in the chunk. a, b: Bvh::slot_coordinates; X_AB: row-major rotation
  // (9) and translation (3). `careful` never leaves kNeedsCare.
  void (*facet_distances)(const double* a, const double* b, const double* X_AB, bool careful,
                          FacetPairs* pairs);
};

const Kernels& ScalarKernels();
#if CT_X86
const Kernels& Avx2Kernels();
const Kernels& Avx512Kernels();
#endif

// The widest this processor runs, or the one named by the environment variable CONTACT_TOOLKIT_SIMD
// (scalar, avx2, avx512) or by SelectKernels.
const Kernels& ActiveKernels();

// Throws std::invalid_argument for a name that is unknown or that this processor cannot run.
void SelectKernels(const char* name);

}  // namespace contact_toolkit
