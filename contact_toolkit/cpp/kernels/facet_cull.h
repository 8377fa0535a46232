// Culling of facets in single precision: eight of A against eight of B, one by one. Included by one
// source file per instruction set, inside an unnamed namespace.
#pragma once

#include <cstdint>

#include "kernels/lanes.h"
#include "kernels/separation.h"
#include "shapes/bvh.h"

namespace contact_toolkit {
namespace {

// Clears the bits (8 j + k) of pairs that lie apart by more than `limit` along a facet's normal, or
// along about the line of their closest points. R, p: of B's boxes in A's. If swept, B goes from
// there by half_way and by as much the other way, and pairs may also lie apart along the direction,
// a unit vector in the frame of A's boxes or zero.
template <bool swept>
std::uint64_t CullFacets(const FacetBlock& a, const FacetBlock& b, const float (&R)[3][3],
                         const float (&p)[3], const float (&half_way)[3],
                         const float (&direction)[3], float limit, std::uint64_t pairs) {
  alignas(32) float corner[3][3][8], normal[3][8], offset[8], stray_b[8];
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < 3; ++i) {
      Float8 v = Fill8(p[i]);
      for (int k = 0; k < 3; ++k) v = v + R[i][k] * Load8(b.vertex[c][k]);
      Store8(corner[c][i], v);
    }
  }
  // How far the planes of b's facets go, and A's seen from B: along their normals.
  Float8 shift{}, strays{}, stray_a{};
  for (int i = 0; i < 3; ++i) {
    Float8 n{};
    for (int k = 0; k < 3; ++k) n = n + R[i][k] * Load8(b.normal[k]);
    Store8(normal[i], n);
    shift = shift + n * Load8(corner[0][i]);
    if constexpr (swept) {
      strays = strays + half_way[i] * n;
      stray_a = stray_a + half_way[i] * Load8(a.normal[i]);
    }
  }
  Store8(offset, shift);
  Store8(stray_b, Absolute(strays));
  stray_a = Absolute(stray_a);

  Float8 middle_a{}, reach_a{};
  alignas(32) float middle_b[8], reach_b[8];
  if constexpr (swept) {
    const Vec<Float8> u{Fill8(direction[0]), Fill8(direction[1]), Fill8(direction[2])};
    Float8 low{}, high{}, low_of_b{}, high_of_b{};
    for (int c = 0; c < 3; ++c) {
      const auto& of_a = a.vertex[c];
      const auto& of_b = corner[c];
      const Float8 x = Dot(Vec<Float8>{Load8(of_a[0]), Load8(of_a[1]), Load8(of_a[2])}, u);
      const Float8 y = Dot(Vec<Float8>{Load8(of_b[0]), Load8(of_b[1]), Load8(of_b[2])}, u);
      low = c == 0 ? x : Least(low, x), high = c == 0 ? x : Most(high, x);
      low_of_b = c == 0 ? y : Least(low_of_b, y), high_of_b = c == 0 ? y : Most(high_of_b, y);
    }
    float stray = 0;
    for (int i = 0; i < 3; ++i) stray += half_way[i] * direction[i];
    middle_a = 0.5f * (low + high), reach_a = 0.5f * (high - low);
    Store8(middle_b, 0.5f * (low_of_b + high_of_b));
    Store8(reach_b, 0.5f * (high_of_b - low_of_b) + (stray < 0 ? -stray : stray));
  }

  const auto facets = [](const auto& from) {
    Triangle<Float8> t;
    for (int c = 0; c < 3; ++c) {
      t.corner[c] = {Load8(from[c][0]), Load8(from[c][1]), Load8(from[c][2])};
    }
    return t;
  };
  const Vec<Float8> centre_a = Middle(facets(a.vertex)), centres_b = Middle(facets(corner));
  alignas(32) float centre_b[3][8];
  Store8(centre_b[0], centres_b.x), Store8(centre_b[1], centres_b.y);
  Store8(centre_b[2], centres_b.z);

  std::uint64_t kept = 0;
  for (int j = 0; j < 8; ++j) {
    if ((pairs >> (8 * j) & 0xff) == 0) continue;
    Float8 low_b{}, high_b{}, low_a{}, high_a{};
    for (int c = 0; c < 3; ++c) {
      // Corner c of the facets of a over facet j's plane, and corner c of facet j over theirs.
      Float8 over_b = Fill8(-offset[j]), over_a = -Load8(a.offset);
      for (int i = 0; i < 3; ++i) {
        over_b = over_b + normal[i][j] * Load8(a.vertex[c][i]);
        over_a = over_a + corner[c][i][j] * Load8(a.normal[i]);
      }
      low_b = c == 0 ? over_b : Least(low_b, over_b);
      high_b = c == 0 ? over_b : Most(high_b, over_b);
      low_a = c == 0 ? over_a : Least(low_a, over_a);
      high_a = c == 0 ? over_a : Most(high_a, over_a);
    }
    Float8 gap_b = Most(low_b, -high_b), gap_a = Most(low_a, -high_a);
    if constexpr (swept) {
      gap_b = gap_b - stray_b[j], gap_a = gap_a - stray_a;
      gap_a = Most(Absolute(middle_a - middle_b[j]) - reach_a - reach_b[j], gap_a);
    }
    std::uint64_t row = Bits(Most(gap_b, gap_a) <= Fill8(limit)) & (pairs >> (8 * j) & 0xff);
    if (row != 0) {
      const auto fill = [j](const float (&from)[3][8]) {
        return Vec<Float8>{Fill8(from[0][j]), Fill8(from[1][j]), Fill8(from[2][j])};
      };
      const Triangle<Float8> ta = facets(a.vertex);
      Triangle<Float8> tb{fill(corner[0]), fill(corner[1]), fill(corner[2])};
      const Vec<Float8> v = centre_a - fill(centre_b);
      if constexpr (swept) {
        const Vec<Float8> half{Fill8(half_way[0]), Fill8(half_way[1]), Fill8(half_way[2])};
        for (Vec<Float8>& c : tb.corner) c = c - half;
        row &= Bits(MayBeNear(ta, Prism<Float8>{tb, half + half}, v, Fill8(limit)));
      } else {
        row &= Bits(MayBeNear(ta, tb, v, Fill8(limit)));
      }
    }
    kept |= row << (8 * j);
  }
  return pairs & kept;
}

}  // namespace
}  // namespace contact_toolkit
