// From candidates to springs: deformations at the nodes, integrals over the triangles, then a row
// for each node that bears load. Nodes are probed only where that is needed.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "base/scratch.h"
#include "web/area/area_candidates.h"
#include "web/area/area_slopes.h"
#include "web/area/area_web.h"
#include "web/area/clipped_integral.h"
#include "web/area/node_table.h"
#include "web/area/wedge_cut.h"

namespace contact_toolkit {

template <typename Probe>
class AreaWeb::Loader {
 public:
  Loader(const AreaWeb& web, const AreaCandidates& candidates, Probe probe, const Pose& X_AB,
         SpringSet* springs)
      : web_(web),
        nodes_(candidates.nodes),
        candidates_(candidates),
        probe_(probe),
        X_AB_(X_AB),
        X_PS_(web.PoseOfSampled(X_AB)),
        springs_(*springs),
        scratch_(Scratch<Memory>([] {})) {}

  // `motion` [m]: the nodes have moved by no more since they were given their clearances.
  void Run(double motion) {
    motion_ = motion;
    springs_.status = kNominal;
    springs_.num_measured = 0;
    scratch_.Begin(nodes_.size());
    scratch_.couplings.clear();
    scratch_.heard.assign(candidates_.num_deeper, 0);
    std::int32_t first = 0;
    for (const AreaCandidates::Part& part : candidates_.parts) {
      if (part.deeper < 0 || scratch_.heard[part.deeper]) LoadPart(first, part.last_triangle);
      first = part.last_triangle;
    }
    Emit();
    if (springs_.slopes.wanted) FindSlopes();
  }

 private:
  static constexpr double kUnknown = NodeTable::kUnknown;
  using State = NodeTable::State;
  using NodeLoad = NodeTable::Load;
  using Probed = NodeTable::Probed;
  struct Memory : NodeTable {
    std::vector<std::uint8_t> heard;  // of the deeper parts, whether what they are parts of is open
    // Only for slopes:
    std::vector<LoadCoupling> couplings;
    std::vector<std::int32_t> row;  // of the springs, of each load; −1: bears none
  };

  const Vec3& Place(std::int32_t i) {
    if (!scratch_.state[i].placed) {
      scratch_.Touch(i);
      scratch_.state[i].placed = true;
      scratch_.probed[i].p = X_PS_ * nodes_[i].p;
    }
    return scratch_.probed[i].p;
  }

  void LoadPart(std::int32_t first, std::int32_t last) {
    for (std::int32_t i = first; i < last;) {
      if (candidates_.clearances[i] > motion_) {  // so it has no parts
        ++i;
        continue;
      }
      const AreaCandidates::Triangle& triangle = candidates_.triangles[i];
      std::int32_t ground = triangle.ground;
      const bool open_smallest = ground == AreaCandidates::kOpenSmallest;
      if (ground == AreaCandidates::kOpen || open_smallest) ground = GroundUnder(triangle);
      if (ground >= 0) {
        LoadFlat(triangle, ground);
        i = triangle.last;
        continue;
      }
      if (triangle.ground == AreaCandidates::kSmallest || open_smallest) LoadSmallest(triangle);
      if (triangle.ground == AreaCandidates::kDeeper) scratch_.heard[triangle.deeper] = 1;
      ++i;
    }
  }

  std::int32_t GroundUnder(const AreaCandidates::Triangle& triangle) const {
    const auto& [a, b, c] = triangle.node;
    return web_.grounds_.Under(X_PS_, {nodes_[a].p, nodes_[b].p, nodes_[c].p}, 0);
  }

  void ProbeAt(std::int32_t i) {
    Probed& node = scratch_.probed[i];
    node.field = probe_(i, Place(i));
    Take(i);
  }

  void ProbeIfNear(std::int32_t i) {
    if constexpr (Probe::kStopsEarly) {
      if (probe_.IfNear(Place(i), nodes_[i].clearance, &scratch_.probed[i].field)) Take(i);
    } else {
      ProbeAt(i);
    }
  }

  // [m] Deformation at a distance, without what is withheld.
  double Felt(double phi) const { return web_.options_.standoff - phi - springs_.withheld; }

  void Take(std::int32_t i) {
    ++springs_.num_measured;
    scratch_.state[i].deformation = Felt(scratch_.probed[i].field.phi);
  }

  // Above one side of the probed body the deformation is linear, above a wedge it is the least of
  // those from its sides.
  void LoadFlat(const AreaCandidates::Triangle& triangle, std::int32_t ground) {
    const auto sides = web_.grounds_.SidesOf(ground);
    const double bulge = RiseOver(triangle);
    WedgeCut cut(static_cast<int>(sides.size()));
    for (std::size_t s = 0; s < sides.size(); ++s) {
      const FlatSides::Side& side = web_.grounds_.side(sides[s]);
      for (int j = 0; j < 3; ++j) {
        cut.depth[s][j] = Felt(Dot(side.normal, Place(triangle.node[j])) - side.offset) + bulge;
      }
      if (!(cut.depth[s][0] > 0 || cut.depth[s][1] > 0 || cut.depth[s][2] > 0)) return;
    }
    const int least = cut.LeastEverywhere();
    if (least >= 0) {
      const auto loads = LoadsOf(triangle, sides[least], ground);
      Load(triangle, loads, cut.depth[least], bulge);
      for (const std::int32_t load : loads) ++scratch_.loads[load].num_facing;
      return;
    }
    LoadPieces(triangle, ground, cut, bulge);
  }

  void LoadPieces(const AreaCandidates::Triangle& triangle, std::int32_t ground,
                  const WedgeCut& cut, double bulge) {
    const auto sides = web_.grounds_.SidesOf(ground);
    const int facing = Facing(triangle, sides);
    std::array<std::array<std::int32_t, 3>, Wedge::kMostSides> loads;
    std::array<bool, Wedge::kMostSides> bears{};
    for (int s = 0; s < cut.num_sides; ++s) {
      const WedgeCut::Piece piece = cut.PieceOf(s);
      std::array<double, 3> sum{};
      Coupling slope{};
      piece.ForEachTriangle([&](const WedgeCut::Corners& corners, double part) {
        AddPiece(triangle.area * part, corners, cut.depth[s], &sum, &slope);
      });
      bears[s] = sum[0] > 0 || sum[1] > 0 || sum[2] > 0;
      if (!bears[s]) continue;
      loads[s] = LoadsOf(triangle, sides[s], ground);
      for (int j = 0; j < 3; ++j) {
        Add(loads[s][j], sum[j], bulge);
        if (s == facing) ++scratch_.loads[loads[s][j]].num_facing;
      }
      if (springs_.slopes.wanted) scratch_.couplings.push_back({loads[s], loads[s], slope});
    }
    ShareOut(triangle);
    if (!springs_.slopes.wanted) return;
    // Where a side comes closer its piece grows at the cost of its neighbour's.
    for (int s = 0; s < cut.num_sides; ++s) {
      for (int t = 0; t < s; ++t) {
        Coupling moved{};
        if (!bears[s] || !bears[t] || !cut.BorderOf(s, t, triangle.area, &moved)) continue;
        scratch_.couplings.push_back({loads[s], loads[t], moved});
        scratch_.couplings.push_back({loads[t], loads[s], moved});
        for (auto& row : moved) {
          for (double& value : row) value = -value;
        }
        scratch_.couplings.push_back({loads[s], loads[s], moved});
        scratch_.couplings.push_back({loads[t], loads[t], moved});
      }
    }
  }

  // Of part of a triangle with the given depths, corners as weights of the whole one's.
  void AddPiece(double area, const WedgeCut::Corners& corners, const std::array<double, 3>& depth,
                std::array<double, 3>* sum, Coupling* slope) const {
    std::array<double, 3> d{}, I{};
    for (int c = 0; c < 3; ++c) {
      for (int j = 0; j < 3; ++j) d[c] += corners[c][j] * depth[j];
    }
    AddClippedIntegral(area, d, {&I[0], &I[1], &I[2]});
    for (int c = 0; c < 3; ++c) {
      for (int j = 0; j < 3; ++j) (*sum)[j] += corners[c][j] * I[c];
    }
    if (!springs_.slopes.wanted) return;
    const Coupling J = ClippedSlope(area, d);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        for (int b = 0; b < 3; ++b) {
          for (int c = 0; c < 3; ++c) {
            (*slope)[i][j] += corners[b][i] * J[b][c] * corners[c][j];
          }
        }
      }
    }
  }

  // Which of the sides a triangle faces most squarely.
  int Facing(const AreaCandidates::Triangle& triangle, std::span<const std::int32_t> sides) {
    const Vec3 &a = Place(triangle.node[0]), &b = Place(triangle.node[1]),
               &c = Place(triangle.node[2]);
    const Vec3 normal = Cross(b - a, c - a);
    int facing = 0;
    double least = kUnknown;
    for (std::size_t s = 0; s < sides.size(); ++s) {
      const double toward = -Dot(normal, web_.grounds_.side(sides[s]).normal);
      if (toward > least) least = toward, facing = static_cast<int>(s);
    }
    return facing;
  }

  // The loads of a triangle's corners above a side.
  std::array<std::int32_t, 3> LoadsOf(const AreaCandidates::Triangle& triangle, std::int32_t side,
                                      std::int32_t ground) {
    std::array<std::int32_t, 3> loads;
    for (int j = 0; j < 3; ++j) loads[j] = scratch_.LoadOf(triangle.node[j], side, ground);
    return loads;
  }

  void LoadSmallest(const AreaCandidates::Triangle& triangle) {
    bool loaded = false;
    for (const std::int32_t i : triangle.node) {
      State& state = scratch_.state[i];
      if (!state.tried) {
        scratch_.Touch(i);
        state.tried = true;
        if (!(nodes_[i].clearance > motion_)) ProbeIfNear(i);
      }
      loaded = loaded || state.deformation > -web_.most_bulge_;
    }
    std::array<double, 3> d{kUnknown, kUnknown, kUnknown};
    double bulge = 0;
    if (loaded) {
      bulge = BulgeOver(triangle);
      for (int j = 0; j < 3; ++j) {
        const std::int32_t i = triangle.node[j];
        if (scratch_.state[i].deformation == kUnknown) ProbeAt(i);
        d[j] = scratch_.state[i].deformation + bulge;
      }
      if (!web_.surface_->closed() && Crosses(triangle)) springs_.status |= kCrossed;
    }
    if (d[0] > 0 || d[1] > 0 || d[2] > 0) Load(triangle, triangle.node, d, bulge);
  }

  // [m] By which a round sampled body is deeper over a triangle, on average, than its corners.
  double RiseOver(const AreaCandidates::Triangle& triangle) const {
    const RoundLattice& round = web_.nodes_->round();
    if (!round) return 0;
    const auto& [a, b, c] = triangle.node;
    return round.BulgeOver({nodes_[a].p, nodes_[b].p, nodes_[c].p});
  }

  // [m] By which a round body is deeper over a triangle, on average, than its corners tell: the
  // mean of 1/2 Σ λ_i λ_j |e_ij|² κ, isotropic, so that it does not depend on the pose.
  double BulgeOver(const AreaCandidates::Triangle& triangle) const {
    if (!(web_.bulge_ > 0)) return RiseOver(triangle);
    const auto& [a, b, c] = triangle.node;
    return web_.bulge_ *
           (SquaredNorm(nodes_[b].p - nodes_[a].p) + SquaredNorm(nodes_[c].p - nodes_[b].p) +
            SquaredNorm(nodes_[a].p - nodes_[c].p));
  }

  // A whole triangle that is deep somewhere.
  void Load(const AreaCandidates::Triangle& triangle, const std::array<std::int32_t, 3>& loads,
            const std::array<double, 3>& d, double bulge) {
    const double n = web_.options_.exponent;
    std::array<double, 3> sum{};
    AddClipped(triangle.area, d, &sum);
    for (int j = 0; j < 3; ++j) Add(loads[j], sum[j], bulge);
    ShareOut(triangle);
    if (!springs_.slopes.wanted) return;
    scratch_.couplings.push_back(
        {loads, loads,
         n == 1 ? ClippedSlope(triangle.area, d) : ClippedSlope(triangle.area, d, n)});
  }

  void AddClipped(double area, const std::array<double, 3>& d, std::array<double, 3>* sum) const {
    const std::array<double*, 3> I{&(*sum)[0], &(*sum)[1], &(*sum)[2]};
    if (web_.options_.exponent == 1) {
      AddClippedIntegral(area, d, I);
    } else {
      AddClippedIntegral(area, d, web_.options_.exponent, I);
    }
  }

  void Add(std::int32_t place, double integral, double bulge) {
    NodeLoad& load = scratch_.loads[place];
    load.integral += integral;
    load.raised += integral * bulge;
  }

  void ShareOut(const AreaCandidates::Triangle& triangle) {
    for (int j = 0; j < 3; ++j) {
      State& state = scratch_.state[triangle.node[j]];
      // A running mean: of equal values that value to the bit.
      state.share += (triangle.share[j] - state.share) / ++state.num_loaded;
    }
  }

  // Whether corners lie on both sides of an open surface.
  bool Crosses(const AreaCandidates::Triangle& triangle) {
    bool front = false, back = false;
    for (const std::int32_t i : triangle.node) {
      Probed& node = scratch_.probed[i];
      if constexpr (!Probe::kTellsSide) node.field.side = web_.surface_->Probe(node.p).side;
      front |= node.field.side > 0;
      back |= node.field.side < 0;
    }
    return front && back;
  }

  void Emit() {
    const std::vector<NodeLoad>& loads = scratch_.loads;
    std::size_t count = 0;
    const auto for_each_load = [&](std::int32_t i, const auto& act) {
      for (std::int32_t load = i; load >= 0; load = loads[load].next) {
        if (loads[load].integral > 0) act(load);
      }
    };
    scratch_.ForEachTouched(
        [&](std::int32_t i) { for_each_load(i, [&](std::int32_t) { ++count; }); });
    springs_.Resize(count);
    if (springs_.slopes.wanted) scratch_.row.assign(loads.size(), -1);
    std::int32_t row = 0;
    auto part = candidates_.parts.begin();
    scratch_.ForEachTouched([&](std::int32_t i) {
      while (i >= part->last_node) ++part;
      const std::int32_t first = loads[i].next < 0 ? i : scratch_.FacedBy(i);
      for_each_load(i, [&](std::int32_t load) {
        if (springs_.slopes.wanted) scratch_.row[load] = row;
        Write(KeyOf(part->patch, i, load == first ? -1 : loads[load].side), i, loads[load], row++);
      });
    });
  }

  // Its name between steps; a node's further sides have others.
  std::uint64_t KeyOf(std::int32_t patch, std::int32_t i, std::int32_t side) const {
    const std::uint64_t of_patch = static_cast<std::uint64_t>(patch) << 32;
    if (side < 0) return of_patch | nodes_[i].index;
    const std::uint64_t pair = static_cast<std::uint64_t>(side) << 32 | nodes_[i].index;
    return of_patch | 1u << 31 | pair * 0x9e3779b97f4a7c15ull >> 33;
  }

  // A node that meets a loaded flat triangle may have been probed too, or not, as others happened
  // to be gathered: its field is that of the side.
  FieldValue FieldAt(std::int32_t i, const NodeLoad& load) const {
    if (load.side < 0) return scratch_.probed[i].field;
    const FlatSides::Side& side = web_.grounds_.side(load.side);
    return {Dot(side.normal, scratch_.probed[i].p) - side.offset, side.normal, 0, -1};
  }

  // [m] What the node is over the ground; above a wedge its side may be farther away.
  double Height(std::int32_t i, const NodeLoad& load, double phi) const {
    if (load.side < 0) return phi;
    for (const std::int32_t s : web_.grounds_.SidesOf(load.ground)) {
      const FlatSides::Side& side = web_.grounds_.side(s);
      phi = std::max(phi, Dot(side.normal, scratch_.probed[i].p) - side.offset);
    }
    return phi;
  }

  void Write(std::uint64_t key, std::int32_t i, const NodeLoad& load, std::size_t row) {
    const double K = web_.options_.stiffness, share = 1 / (web_.options_.exponent + 1);
    const AreaCandidates::Node& node = nodes_[i];
    const Vec3& p = scratch_.probed[i].p;
    const FieldValue field = FieldAt(i, load);
    const double height = Height(i, load, field.phi);
    const double elastic = K * load.integral;
    if (-height > web_.capture_depth_) springs_.status |= kBeyondCapture;
    springs_.key[row] = key;
    springs_.deformation[row] = Felt(height);
    springs_.elastic[row] = elastic;
    // The energy is homogeneous of degree n + 1 in the deformations, whose derivatives are elastic.
    springs_.energy[row] = share * (elastic * Felt(field.phi) + K * load.raised);
    // Whole for each of a node's sides: their parts of it would change with the pose.
    springs_.stiffness[row] = K * scratch_.state[i].share;
    springs_.multiplicity[row] = 1;
    const double steepness = Norm(field.gradient);
    const Vec3 normal = (steepness > 0 ? 1 / steepness : 0.0) * field.gradient;
    const Vec3 foot = p - height * normal;
    springs_.steepness[row] = steepness;
    if (web_.samples_a_) {
      springs_.p_AC[row] = springs_.p_ACa[row] = node.p;
      springs_.p_ACb[row] = X_AB_ * foot;
      springs_.normal_A[row] = X_AB_.R * normal;
    } else {
      springs_.p_AC[row] = springs_.p_ACb[row] = p;
      springs_.p_ACa[row] = foot;
      springs_.normal_A[row] = -normal;
    }
  }

  void FindSlopes() {
    SpringSlopes& slopes = springs_.slopes;
    slopes.clear();
    slopes.nodes_on_a = web_.samples_a_;
    slopes.bend.resize(springs_.size());
    scratch_.ForEachTouched([&](std::int32_t i) {
      if (scratch_.row[i] < 0 || scratch_.loads[i].side >= 0) return;  // flat
      const auto& [p, field] = scratch_.probed[i];
      const Symmetric3 curvature = probe_.Curvature(p, field);
      slopes.bend[scratch_.row[i]] = web_.samples_a_ ? Rotated(X_AB_.R, curvature) : curvature;
    });
    FindElasticSlopes(scratch_.couplings, scratch_.row, web_.options_.stiffness, &springs_);
  }

  const AreaWeb& web_;
  const std::vector<AreaCandidates::Node>& nodes_;
  const AreaCandidates& candidates_;
  Probe probe_;
  const Pose X_AB_, X_PS_;
  double motion_ = 0;
  SpringSet& springs_;
  Memory& scratch_;
};

}  // namespace contact_toolkit
