// Culling for swept queries: the inner loops of SweptSearch, compiled once for each instruction
// set.
//
// Over a slice of the motion a point of B strays from the straight line between its two end
// positions by at most angle² / 8 times its distance from the axis, and a box turns by at most half
// the slice's angle from its attitude in the middle. So a moving box stays within its middle
// attitude, slid along the line its centre's end positions span and swollen by those two terms.
// Boxes are separated along A's axes and, in a pure translation, along the directions across both
// the motion and an axis of A; facets along their normals and along one direction the query
// suggests.
#pragma once

#include <cstdint>

#include "kernels/kernels.h"
#include "math/motion.h"
#include "shapes/bvh.h"

namespace contact_toolkit {

// What the kernels need of a slice, in single precision, between the frames of the two hierarchies'
// boxes: where it says A and B below, these are meant.
struct SweptCull {
  float R_begin[3][3], p_begin[3], R_end[3][3], p_end[3];
  float R[3][3], abs_R[3][3];  // in the middle
  float turn;                  // half the slice's angle; exactly zero in a translation
  float bow;                   // angle² / 8
  float axis[3], from_Bo[3];   // of rotation, in B; of B's hierarchy's origin from Bo
  int across_count;            // unit vectors across the motion, in A and in B (absolute values)
  float across[3][3], abs_across_A[3][3], abs_across_B[3][3];
  float slack;  // [m] covers all single-precision rounding
  // Whether the shapes are so far apart that the slack hides their facets from each other. Then the
  // kernels' bounds are useless, and SquaredBound's must do.
  bool coarse;
  Pose begin, end;  // as above, in double precision
  Mat3 middle;
  Vec3 axis_B;

  SweptCull(const Bvh& a, const Bvh& b, const Motion& motion, const TimeSlice& slice);

  // A lower bound of the squared distance over the slice of child k of a from child j of b.
  double SquaredBound(const BvhNode& a, int k, const BvhNode& b, int j) const;
};

struct SweptKernels {
  // Leaves lower bounds of squared distances over the slice in bound[8 j + k], of child k of a from
  // child j of b, and sets the bits of `near` where they are within squared_reach. Returns the
  // furthest [m] that any child of b goes, either way from the middle.
  float (*box_bounds)(const BvhNode& a, const BvhNode& b, const SweptCull& cull,
                      float squared_reach, float bound[64], std::uint64_t* near);

  // The same for a translation, slabs included where they may tell more: less is done for bounds
  // that exceed the squared `limit`. Returns the bits of those within it.
  std::uint64_t (*translation_bounds)(const BvhNode& a, const BvhNode& b, const SweptCull& cull,
                                      float limit, float bound[64]);

  // And in order[8 j + k] numbers in whose order to look at the pairs: the squared distances of the
  // boxes, and of their middles times `middles`, when B's boxes' frame is at p in that of A's.
  std::uint64_t (*translation_orders)(const BvhNode& a, const BvhNode& b, const SweptCull& cull,
                                      const float p[3], float limit, float middles, float bound[64],
                                      float order[64]);

  // Clears the bits (8 j + k) of facet pairs that stay apart by more than reach [m] over the slice
  // along a facet's normal, about the line of their closest points or the direction, a unit vector
  // in the frame of A's boxes or zero.
  std::uint64_t (*cull_facets)(const FacetBlock& a, const FacetBlock& b, const SweptCull& cull,
                               const float direction[3], float reach, std::uint64_t pairs);

  // For a translation by `way` from X_AB (as in Kernels): leaves -1 for the distance of pairs that
  // certainly stay farther apart than limit [m], up to rounding; of the others an upper bound of
  // their least distance. `line` is a vector in A that is likely to separate them, or zero.
  void (*cull_prisms)(const double* a, const double* b, const double* X_AB, const double* way,
                      const double* line, double limit, FacetPairs* pairs);
};

const SweptKernels& ScalarSweptKernels();
const SweptKernels& VectorSweptKernels();
#if CT_AVX
const SweptKernels& Avx2SweptKernels();
const SweptKernels& Avx512SweptKernels();
#endif

// Of the same instruction set as ActiveKernels().
const SweptKernels& ActiveSweptKernels();

}  // namespace contact_toolkit
