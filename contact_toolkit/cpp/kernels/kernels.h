// The inner loops of mesh–mesh proximity, compiled once for each instruction set and chosen at run
// time. Nothing here allocates or throws; the drivers (witness.cpp, distance.cpp) do the rest.
// All instruction sets give the same bits: the operations and their order are the same, only the
// number of lanes differs, and fused multiply-add is off.
#pragma once

#include <cstddef>
#include <cstdint>

#include "shapes/bvh.h"

namespace contact_toolkit {

// The pose of B in A between the frames of the two hierarchies' boxes, in single precision for
// culling.
struct CullPose {
  float R[3][3];
  float abs_R[3][3];
  float p[3];
  float slack;  // [m] covers all single-precision rounding
};

// A point in the frame of a hierarchy's boxes, in single precision for culling.
struct CullPoint {
  float p[3];
  float slack;  // [m] covers the rounding of a box's distance; of a facet's, twice
};

// Where on a facet a closest point lies. Corners and edges are numbered by the sorted vertices of
// the slot: edge 0 = (0,1), 1 = (1,2), 2 = (0,2), running from the first to the second.
inline constexpr int kOnCorner = 0;  // + corner
inline constexpr int kOnEdge = 3;    // + edge
inline constexpr int kInside = 6;
inline constexpr int kCrossing = 7;    // both: an edge of one facet pierces the other
inline constexpr int kNeedsCare = 64;  // added to spot_a: ask a more careful kernel

// How much care the facet kernel takes.
enum class Care {
  kGuessed,  // what kFast finds, at less cost; leaves kNeedsCare where that is not proven
  kFast,     // leaves kNeedsCare where it may not be accurate; facets must not be thin
  kCareful,  // for any facets that are not thin
  kProven,   // careful, for thin facets: leaves kNeedsCare where the answer is not proven
};

// A chunk of facet pairs, structure of arrays: the kernel reads the slots and writes the rest.
struct FacetPairs {
  static constexpr int kCapacity = 256;
  static constexpr int kPadded = kCapacity + 2 * kBvhWidth;  // the last batch is filled up
  int count = 0;
  int unguessed = 0;  // chunks to come that are measured without a guess
  std::int32_t slot_a[kPadded], slot_b[kPadded];
  double distance[kPadded];  // [m] between the points below
  double spot_a[kPadded], spot_b[kPadded];
  // In A; where facets cross the middle of the segment, or not a number where its ends are unclear.
  double point_a[3][kPadded], point_b[3][kPadded];
  double normal[3][kPadded];  // from B towards A; unit where the distance is not tiny

  // Takes over what was measured for entry i of another chunk.
  void CopyMeasured(int k, const FacetPairs& other, int i) {
    distance[k] = other.distance[i];
    spot_a[k] = other.spot_a[i], spot_b[k] = other.spot_b[i];
    for (int axis = 0; axis < 3; ++axis) {
      point_a[axis][k] = other.point_a[axis][i];
      point_b[axis][k] = other.point_b[axis][i];
      normal[axis][k] = other.normal[axis][i];
    }
  }
};

// The closest points of two features.
struct FeatureWitness {
  Vec3 p_ACa, p_ACb, normal_A;
  double distance;  // [m]; negative where uncertain
};

// One number of each of eight pairs of features.
struct alignas(64) LaneRow {
  double lane[kBvhWidth];
};

// Eight pairs of features of the same kinds, to be measured together. Rows, from the first: the
// corners of A's features, those of B's in B, three rows each; the longest edge [m] of the facets
// that meet there; then, in single precision and two to a row, the ways in which these facets go on
// from the feature, three components each, those of A before those of B. A way is the vector to one
// further corner of a facet (on B: from it), over the longest edge.
struct FeatureBlock {
  std::int32_t corners_a, corners_b;  // 1: vertices, 2: edges, 3: facets
  std::int32_t ways_a, ways_b;        // of each lane; filled up by repetition
  std::int64_t first_row;
  double nearest;  // [m] least distance of its pairs when they were gathered
};

struct Kernels {
  const char* name;
  int lanes;  // of the facet kernel

  // Bit 8 j + k is set when child k of a and child j of b may be closer than reach [m].
  std::uint64_t (*box_pairs)(const BvhNode& a, const BvhNode& b, const CullPose& X_AB, float reach);

  // The same test for a squared `limit`, leaving lower bounds of the squared distances in
  // bound[8 j + k]. Less is done for bounds that exceed it.
  std::uint64_t (*box_bounds)(const BvhNode& a, const BvhNode& b, const CullPose& X_AB, float limit,
                              float bound[64]);

  // And in order[8 j + k] numbers in whose order to look at the pairs: these bounds and, as many
  // are zero where boxes overlap, the boxes' middles' squared distance times `middles`.
  std::uint64_t (*box_orders)(const BvhNode& a, const BvhNode& b, const CullPose& X_AB, float limit,
                              float middles, float bound[64], float order[64]);

  // Lower bounds of the squared distances of a point from the boxes of a node's children; a bit is
  // set for those up to `limit` ...
  unsigned (*point_box_bounds)(const BvhNode& node, const CullPoint& point, float limit,
                               float bound[8]);

  // ... and from the facets of a bottom node.
  unsigned (*point_facet_bounds)(const BvhNode& node, const FacetBlock& block,
                                 const CullPoint& point, float limit, float bound[8]);

  // Clears the bits of facet pairs that lie apart by more than reach along a facet's normal, or
  // along about the line of their closest points.
  std::uint64_t (*cull_by_axes)(const FacetBlock& a, const FacetBlock& b, const CullPose& X_AB,
                                float reach, std::uint64_t pairs);

  // Least distances of all pairs in the chunk. a, b: Bvh::slot_coordinates; X_AB: row-major
  // rotation (9) and translation (3).
  void (*facet_distances)(const double* a, const double* b, const double* X_AB, Care care,
                          FacetPairs* pairs);

  // The closest points of the features of each block, as facet_distances places them, if no other
  // case of that kernel can win on any of their facets; otherwise a negative distance, and a bit in
  // uncertain (one number a block). Blocks not `near` are taken for infinitely far.
  // touching [m]: the distance from which witness points have a direction.
  void (*feature_distances)(const LaneRow* rows, const FeatureBlock* blocks, std::size_t count,
                            const double* X_AB, double near, double touching,
                            FeatureWitness* witnesses, std::uint8_t* uncertain);
};

// The careful kernel in extended precision, one pair at a time: for thin facets that graze or
// touch, or whose planes double precision cannot tell well enough.
void ThinFacetDistances(const double* a, const double* b, const double* X_AB, FacetPairs* pairs);

const Kernels& ScalarKernels();
const Kernels& VectorKernels();
#if CT_AVX
const Kernels& Avx2Kernels();
const Kernels& Avx512Kernels();
#endif

// The widest this processor runs, or the one named by the environment variable CONTACT_TOOLKIT_SIMD
// (scalar, vector, avx2, avx512) or by SelectKernels. Throws where that one does not run.
const Kernels& ActiveKernels();

// Throws std::invalid_argument for a name that is unknown or that this processor cannot run.
void SelectKernels(const char* name);

}  // namespace contact_toolkit
