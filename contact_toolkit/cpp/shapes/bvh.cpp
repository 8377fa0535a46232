#include "shapes/bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "base/column.h"
#include "base/tolerances.h"

namespace contact_toolkit {
namespace {

constexpr int kBins = 16;

struct Box {
  Vec3 lower{kInfinity, kInfinity, kInfinity};
  Vec3 upper{-kInfinity, -kInfinity, -kInfinity};
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  void Add(const Box& b) {
    for (int i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], b.lower[i]);
      upper[i] = std::max(upper[i], b.upper[i]);
    }
  }
  void Add(const Vec3& p) { Add(Box{p, p}); }
  double HalfArea() const {
    const Vec3 d = upper - lower;
    return d.x < 0 ? 0 : d.x * d.y + d.y * d.z + d.z * d.x;
  }
};

// A facet on its way to a leaf. Facets are moved rather than pointed to, so that every pass over a
// range of them is one over memory.
struct Item {
  Box box;
  std::int32_t facet;

  double Middle(int axis) const { return 0.5 * (box.lower[axis] + box.upper[axis]); }
};

// How the normals of facets are spread, whatever their sense: the sum of n nᵀ by area.
struct NormalSpread {
  double xx = 0, yy = 0, zz = 0, xy = 0, yz = 0, zx = 0;

  void Add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 n = Cross(b - a, c - a);
    const double area = Norm(n);
    if (!(area > 0)) return;
    const Vec3 u = n / area;
    Add({n.x * u.x, n.y * u.y, n.z * u.z, n.x * u.y, n.y * u.z, n.z * u.x});
  }
  void Add(const NormalSpread& b) {
    xx += b.xx, yy += b.yy, zz += b.zz, xy += b.xy, yz += b.yz, zx += b.zx;
  }
  // Most of the normals lie about along it: roughly the largest eigenvector. Zero without any.
  Vec3 Direction() const {
    const Mat3 m{{Vec3{xx, xy, zx}, Vec3{xy, yy, yz}, Vec3{zx, yz, zz}}};
    Vec3 v = Normalized(m.row[xx >= yy && xx >= zz ? 0 : yy >= zz ? 1 : 2]);
    for (int i = 0; i < 4; ++i) v = Normalized(m * v);
    return v;
  }
};

struct Range {
  int first, count;
  Box box;  // of the facets
};

class Builder {
 public:
  Builder(std::span<const Vec3> vertices, std::span<const std::array<std::int32_t, 3>> faces,
          const Mat3& axes)
      : vertices_(vertices), faces_(faces), items_(faces.size()) {
    bvh_.axes = axes;
    const Box all = BoxFacets();
    bvh_.half_extent = 0.5 * (all.upper - all.lower);
    bvh_.size = std::max({bvh_.half_extent.x, bvh_.half_extent.y, bvh_.half_extent.z});
    // Most bottom nodes are full; what is reserved and not used is never touched.
    bvh_.nodes.reserve(faces.size() / 5 + 1);
    bvh_.blocks.reserve(faces.size() / 7 + 1);
    BuildNode({0, static_cast<int>(faces.size()), all}, 1);
    FillSlots();
    FillSlabs(0, 0);
  }

  Bvh Take() { return std::move(bvh_); }

 private:
  // Sets the origin and the facets' boxes about it; returns the box of all. The vertices are taken
  // from near the origin before they are turned: far from the frame's own they would round more.
  Box BoxFacets() {
    Box in_mesh, turned;
    for (const auto& face : faces_) {
      for (const std::int32_t v : face) in_mesh.Add(vertices_[v]);
    }
    const Vec3 middle = 0.5 * (in_mesh.lower + in_mesh.upper);
    for (const auto& face : faces_) {
      for (const std::int32_t v : face) turned.Add(bvh_.axes * (vertices_[v] - middle));
    }
    bvh_.origin = middle + Transpose(bvh_.axes) * (0.5 * (turned.lower + turned.upper));
    local_.reserve(vertices_.size());
    for (const Vec3& v : vertices_) local_.push_back(bvh_.Local(v));
    Box all;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      items_[f] = {Box{}, static_cast<std::int32_t>(f)};
      for (const std::int32_t v : faces_[f]) items_[f].box.Add(local_[v]);
      all.Add(items_[f].box);
    }
    return all;
  }

  std::span<Item> Items(const Range& range) {
    return {&items_[range.first], static_cast<std::size_t>(range.count)};
  }

  // Splits a range in two where the surface area heuristic is least; near the leaves at a multiple
  // of the node width, so that bottom nodes are full.
  std::pair<Range, Range> Split(const Range& range) {
    Box centers;
    for (const Item& item : Items(range)) {
      centers.Add(Vec3{item.Middle(0), item.Middle(1), item.Middle(2)});
    }
    const int at = range.count <= kExactSplit ? SortedSplit(range) : BinnedSplit(range, centers);
    Range left{range.first, at, {}}, right{range.first + at, range.count - at, {}};
    for (Range* side : {&left, &right}) {
      for (const Item& item : Items(*side)) side->box.Add(item.box);
    }
    return {left, right};
  }

  // Cost of a side: its surface area times the bottom nodes it needs.
  static double Cost(const Box& box, int count) {
    return box.HalfArea() * ((count + kBvhWidth - 1) / kBvhWidth);
  }

  int SortedSplit(const Range& range) {
    const std::span<Item> items = Items(range);
    struct Place {
      double middle;
      std::int32_t facet, item;
    };
    std::array<Place, kExactSplit> sorted, best_sorted;
    std::array<double, kExactSplit + 1> right_cost;
    double best = Box::kInfinity;
    int best_at = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i < range.count; ++i) sorted[i] = {items[i].Middle(axis), items[i].facet, i};
      std::sort(sorted.begin(), sorted.begin() + range.count, [](const Place& a, const Place& b) {
        return a.middle != b.middle ? a.middle < b.middle : a.facet < b.facet;
      });
      Box box;
      for (int i = range.count - 1; i > 0; --i) {
        box.Add(items[sorted[i].item].box);
        right_cost[i] = Cost(box, range.count - i);
      }
      box = Box{};
      bool better = false;
      for (int i = 1; i < range.count; ++i) {
        box.Add(items[sorted[i - 1].item].box);
        const double cost = Cost(box, i) + right_cost[i];
        if (cost < best) best = cost, best_at = i, better = true;
      }
      if (better) best_sorted = sorted;
    }
    std::array<Item, kExactSplit> moved;
    std::copy(items.begin(), items.end(), moved.begin());
    for (int i = 0; i < range.count; ++i) items[i] = moved[best_sorted[i].item];
    return best_at;
  }

  int BinnedSplit(const Range& range, const Box& centers) {
    const std::span<Item> items = Items(range);
    const auto bin_of = [&](const Item& item, int axis) {
      const double width = centers.upper[axis] - centers.lower[axis];
      const double t = (item.Middle(axis) - centers.lower[axis]) / width;
      return width > 0 ? std::min(kBins - 1, static_cast<int>(t * kBins)) : 0;
    };
    Box box[3][kBins];
    int count[3][kBins] = {};
    for (const Item& item : items) {
      for (int axis = 0; axis < 3; ++axis) {
        const int bin = bin_of(item, axis);
        box[axis][bin].Add(item.box);
        ++count[axis][bin];
      }
    }
    double best = Box::kInfinity;
    int best_axis = -1, best_bin = 0;
    for (int axis = 0; axis < 3; ++axis) {
      double right_cost[kBins];
      Box sweep;
      int n = 0;
      for (int b = kBins - 1; b > 0; --b) {
        sweep.Add(box[axis][b]);
        right_cost[b] = Cost(sweep, n += count[axis][b]);
      }
      sweep = Box{};
      n = 0;
      for (int b = 1; b < kBins; ++b) {
        sweep.Add(box[axis][b - 1]);
        n += count[axis][b - 1];
        if (n == 0 || n == range.count) continue;
        const double cost = Cost(sweep, n) + right_cost[b];
        if (cost < best) best = cost, best_axis = axis, best_bin = b;
      }
    }
    if (best_axis < 0) return range.count / 2;  // all centres coincide
    const auto middle = std::stable_partition(items.begin(), items.end(), [&](const Item& item) {
      return bin_of(item, best_axis) < best_bin;
    });
    return static_cast<int>(middle - items.begin());
  }

  // Returns the index of the node made for the range.
  int BuildNode(const Range& range, int depth) {
    const int index = static_cast<int>(bvh_.nodes.size());
    bvh_.nodes.emplace_back();
    bvh_.depth = std::max(bvh_.depth, depth);
    if (range.count <= kBvhWidth) {
      BvhNode& node = bvh_.nodes[index];
      node.block = static_cast<int>(bvh_.blocks.size());
      node.count = range.count;
      bvh_.blocks.emplace_back();
      for (int k = 0; k < kBvhWidth; ++k) {
        SetLane(&node, k, items_[range.first + (k < range.count ? k : 0)].box, k < range.count);
        node.child[k] = k < range.count ? range.first + k : -1;
      }
      return index;
    }
    // Open the child with the largest surface until there are eight.
    std::vector<Range> children{range};
    while (children.size() < kBvhWidth) {
      int widest = -1;
      double most = -1;
      for (std::size_t i = 0; i < children.size(); ++i) {
        if (children[i].count <= kBvhWidth) continue;
        const double cost = Cost(children[i].box, children[i].count);
        if (cost > most) most = cost, widest = static_cast<int>(i);
      }
      if (widest < 0) break;
      const auto [left, right] = Split(children[widest]);
      children[widest] = left;
      children.insert(children.begin() + widest + 1, right);
    }
    const int count = static_cast<int>(children.size());
    for (int k = 0; k < kBvhWidth; ++k) {
      const Range& child = children[k < count ? k : 0];
      const int child_index = k < count ? BuildNode(child, depth + 1) : -1;
      BvhNode& node = bvh_.nodes[index];
      node.count = count;
      node.child[k] = child_index;
      SetLane(&node, k, child.box, k < count);
    }
    return index;
  }

  // Rounds the box outwards to single precision; unused lanes can never pass a test.
  void SetLane(BvhNode* node, int k, const Box& box, bool used) const {
    for (int i = 0; i < 3; ++i) {
      const auto rounded = static_cast<float>(0.5 * (box.lower[i] + box.upper[i]));
      const double half = std::max(box.upper[i] - rounded, rounded - box.lower[i]);
      constexpr float kBig = std::numeric_limits<float>::infinity();
      node->center[i][k] = rounded;
      node->half[i][k] = used ? std::nextafter(static_cast<float>(half), kBig) : -kBig;
    }
  }

  void FillSlots() {
    const std::size_t count = faces_.size();
    bvh_.slot_facet.resize(count);
    bvh_.slot_vertices.resize(count);
    bvh_.slot_coordinates.resize(9 * count);
    bvh_.slot_thin.resize(count);
    for (std::size_t slot = 0; slot < count; ++slot) {
      bvh_.slot_facet[slot] = items_[slot].facet;
      std::array<std::int32_t, 3> v = faces_[items_[slot].facet];
      std::sort(v.begin(), v.end());
      bvh_.slot_vertices[slot] = v;
      for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < 3; ++i)
          bvh_.slot_coordinates[9 * slot + 3 * c + i] = vertices_[v[c]][i] + 0.0;
      }
      const Vec3 u = vertices_[v[1]] - vertices_[v[0]], w = vertices_[v[2]] - vertices_[v[0]];
      const double longest = std::max({SquaredNorm(u), SquaredNorm(w), SquaredNorm(u - w)});
      bvh_.slot_thin[slot] = !(SquaredNorm(Cross(u, w)) > kThinFacet * longest * longest);
      bvh_.any_thin = bvh_.any_thin || bvh_.slot_thin[slot];
    }
    for (const BvhNode& node : bvh_.nodes) {
      if (node.bottom()) FillBlock(node, &bvh_.blocks[node.block]);
    }
  }

  void FillBlock(const BvhNode& node, FacetBlock* block) const {
    for (int k = 0; k < kBvhWidth; ++k) {
      const int slot = node.child[k < node.count ? k : 0];
      Vec3 p[3];
      for (int c = 0; c < 3; ++c) {
        p[c] = local_[bvh_.slot_vertices[slot][c]];
        for (int i = 0; i < 3; ++i) block->vertex[c][i][k] = static_cast<float>(p[c][i]);
      }
      // For culling any direction will do along which the facet is flat to within the slack. A
      // normal is off by the corners' rounding over the facet's height, and so is the facet's
      // extent along it by that times its length.
      const Vec3 u = p[1] - p[0], w = p[2] - p[0], n = Cross(u, w);
      const double longest = std::max({SquaredNorm(u), SquaredNorm(w), SquaredNorm(u - w)});
      const bool flat = SquaredNorm(n) > kFlatFacet * longest * longest;
      const Vec3 normal = flat ? Normalized(n) : Vec3{};
      for (int i = 0; i < 3; ++i) block->normal[i][k] = static_cast<float>(normal[i]);
      block->offset[k] = static_cast<float>(Dot(normal, p[0]));
    }
  }

  // What is below a node: its slots are in a row.
  struct Below {
    int end;  // one past its last slot
    NormalSpread spread;
  };

  // Fits slabs around the children of a node, whose slots begin at `first`, and of those below it.
  Below FillSlabs(int index, int first) {
    Below below{first, {}};
    for (int k = 0; k < bvh_.nodes[index].count; ++k) {
      BvhNode& node = bvh_.nodes[index];
      const int begin = below.end;
      Below child{begin + 1, {}};
      if (node.bottom()) {
        const auto& v = bvh_.slot_vertices[begin];
        child.spread.Add(local_[v[0]], local_[v[1]], local_[v[2]]);
      } else {
        child = FillSlabs(node.child[k], begin);
      }
      if (child.end - begin <= kMostInSlab) FitSlab(&node, k, begin, child);
      below.end = child.end;
      below.spread.Add(child.spread);
    }
    return below;
  }

  void FitSlab(BvhNode* node, int k, int begin, const Below& child) const {
    const Vec3 direction = child.spread.Direction();
    Vec3 n;  // what is rounded must be the same for all
    for (int i = 0; i < 3; ++i) n[i] = node->normal[i][k] = static_cast<float>(direction[i]);
    double lowest = Box::kInfinity, highest = -Box::kInfinity;
    for (int slot = begin; slot < child.end; ++slot) {
      for (const std::int32_t v : bvh_.slot_vertices[slot]) {
        const double at = Dot(n, local_[v]);
        lowest = std::min(lowest, at);
        highest = std::max(highest, at);
      }
    }
    const auto middle = static_cast<float>(0.5 * (lowest + highest));
    const auto thick = static_cast<float>(std::max(highest - middle, middle - lowest));
    node->middle[k] = middle;
    node->thick[k] = std::nextafter(thick, std::numeric_limits<float>::infinity());
  }

  static constexpr int kMostInSlab = 1024;  // larger patches are rarely flat, and take long to fit
  static constexpr int kExactSplit = 128;   // below it all split positions are tried

  std::span<const Vec3> vertices_;
  std::span<const std::array<std::int32_t, 3>> faces_;
  Column<Item> items_;       // large, and soon done with
  std::vector<Vec3> local_;  // the vertices in the boxes' frame
  Bvh bvh_;
};

}  // namespace

std::size_t Bvh::MemoryBytes() const {
  return nodes.size() * sizeof(BvhNode) + blocks.size() * sizeof(FacetBlock) +
         slot_facet.size() * (sizeof(std::int32_t) + sizeof(slot_vertices[0]) + 9 * sizeof(double) +
                              sizeof(std::uint8_t));
}

Bvh BuildBvh(std::span<const Vec3> vertices, std::span<const std::array<std::int32_t, 3>> faces,
             const Mat3& axes) {
  return Builder(vertices, faces, axes).Take();
}

}  // namespace contact_toolkit
