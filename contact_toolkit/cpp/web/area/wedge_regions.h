// Where a body is, as far as a ball reaches, what lies behind two to four planes: about the convex
// edges and corners between sides that are flat and not round. Inside it the distance is the
// largest of those from the planes. So it is linear in pieces, and a triangle of any size may be
// cut into those.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/lazy.h"
#include "shapes/bvh.h"
#include "web/area/flat_regions.h"

namespace contact_toolkit {

struct Wedge {
  static constexpr int kMostSides = 4;
  std::array<std::int32_t, kMostSides> side{};
  int count = 0;
};

class WedgeRegions {
 public:
  WedgeRegions(std::shared_ptr<const ProbedSurface> surface,
               std::shared_ptr<const FlatRegions> flats, double finest);
  ~WedgeRegions();

  bool empty() const { return !edges_; }
  const Wedge& wedge(std::int32_t index) const { return wedges_[index]; }

  // Of a wedge: it is the body within `clear` of `center`.
  KnownRegion About(const Vec3& center, double radius) const;

 private:
  class Beyond;

  void FindWedges();
  std::int32_t Add(Wedge wedge);
  KnownRegion Measure(const Vec3& p, double least) const;
  double ClearOf(std::int32_t wedge, const Vec3& p) const;
  const Beyond& BeyondOf(std::int32_t wedge) const;

  std::shared_ptr<const ProbedSurface> surface_;
  std::shared_ptr<const FlatRegions> flats_;
  std::vector<Wedge> wedges_;
  std::vector<Lazy<Beyond>> beyond_;
  std::unique_ptr<Bvh> edges_;  // the sharp ones, as facets that repeat a vertex; null: none
  std::vector<std::array<std::int32_t, 3>> wedges_of_;  // an edge: its own, those of its ends; -1
  std::vector<std::vector<std::int32_t>> facets_of_;    // each side
  RegionMemo memo_;
};

}  // namespace contact_toolkit
