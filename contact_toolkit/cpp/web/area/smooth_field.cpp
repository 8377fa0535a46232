#include "web/area/smooth_field.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/tolerances.h"
#include "query/point/point_distance.h"
#include "web/area/flat_sides.h"
#include "web/area/quadratic_spline.h"

namespace contact_toolkit {
// A node of the tree over the bricks: of the lowest level it holds bricks, else branches.
struct SmoothField::Branch {
  static constexpr int kChildren = kFanout * kFanout * kFanout;
  explicit Branch(int level)
      : branches(level > 0 ? new Lazy<Branch>[kChildren] : nullptr),
        bricks(level > 0 ? nullptr : new Lazy<Brick>[kChildren]) {}
  std::unique_ptr<Lazy<Branch>[]> branches;
  std::unique_ptr<Lazy<Brick>[]> bricks;
};

SmoothField::SmoothField(std::shared_ptr<const ProbedSurface> surface, double cell)
    : surface_(std::move(surface)), cell_(cell), inverse_cell_(1 / cell) {
  const CollisionMesh& mesh = surface_->mesh();
  origin_ = 0.5 * (mesh.lower() + mesh.upper());
  // The tree covers the surface and as much again on either side.
  double covered = kBrick * kFanout * cell_;
  while (covered < 3 * mesh.diagonal()) covered *= kFanout, ++levels_;
  root_ = std::make_unique<Branch>(levels_ - 1);
  std::vector<CollisionMesh::Triple> segments;
  for (const std::int32_t edge : FindCreasesOfFlats(mesh)) {
    const auto [a, b] = mesh.edges()[edge];
    segments.push_back({a, b, b});
  }
  if (segments.empty()) return;
  sharp_edges_ = std::make_unique<Bvh>(BuildBvh(mesh.vertices(), segments));
  sharp_distances_ = std::make_unique<LatticeMemo>(0.25 * cell_, 0.5 * mesh.diagonal());
}

SmoothField::~SmoothField() = default;

// The coefficients at n³ lattice points from `first` on: the distances less an eighth of their
// second differences along the axes, which makes the spline reproduce quadratics.
template <int n>
void SmoothField::Coefficients(const std::array<std::int32_t, 3>& first,
                               double* coefficients) const {
  constexpr int m = n + 2;  // with the neighbours on either side
  double phi[m][m][m];
  std::int32_t plane_hint = -1;
  for (int i = 0; i < m; ++i) {
    std::int32_t row_hint = plane_hint;
    for (int j = 0; j < m; ++j) {
      std::int32_t hint = row_hint;
      for (int k = 0; k < m; ++k) {
        const auto border = [](int l) { return l == 0 || l == m - 1; };
        if (border(i) + border(j) + border(k) > 1) continue;  // no second difference needs it
        const Vec3 p{(first[0] + i - 1) * cell_, (first[1] + j - 1) * cell_,
                     (first[2] + k - 1) * cell_};
        const FieldValue value = surface_->Probe(origin_ + p, hint);
        phi[i][j][k] = value.phi;
        hint = value.slot;
        if (k <= 1) row_hint = hint;
      }
      if (j <= 1) plane_hint = row_hint;
    }
  }
  for (int i = 1; i <= n; ++i) {
    for (int j = 1; j <= n; ++j) {
      for (int k = 1; k <= n; ++k) {
        const double around = phi[i - 1][j][k] + phi[i + 1][j][k] + phi[i][j - 1][k] +
                              phi[i][j + 1][k] + phi[i][j][k - 1] + phi[i][j][k + 1];
        *coefficients++ = phi[i][j][k] - 0.125 * (around - 6 * phi[i][j][k]);
      }
    }
  }
}

void SmoothField::FillSpline(const std::array<std::int32_t, 3>& brick, Spline* filled) const {
  Coefficients<kPoints>({brick[0] * kBrick, brick[1] * kBrick, brick[2] * kBrick},
                        filled->coefficients.data());
  filled->coefficients.back() = 0;
  float* least = filled->least.data();
  for (int i = 0; i < kBrick; ++i) {
    for (int j = 0; j < kBrick; ++j) {
      for (int k = 0; k < kBrick; ++k) {
        double lowest = HUGE_VAL;
        for (int n = 0; n < 27; ++n) {
          const int x = i + n / 9, y = j + n / 3 % 3, z = k + n % 3;
          lowest = std::min(lowest, filled->coefficients[(x * kPoints + y) * kPoints + z]);
        }
        *least++ = std::nextafter(static_cast<float>(lowest), -HUGE_VALF);
      }
    }
  }
}

// Of the exact distance, at a lattice point.
double SmoothField::WeightAt(const Vec3& p) const {
  const double far = kGone * cell_;
  const ClosestPoint closest = FindClosestPoint(*sharp_edges_, p, far * far);
  if (closest.slot < 0) return 0;
  const double away = std::sqrt(closest.squared_distance) * inverse_cell_;
  const double t = std::clamp((kGone - away) / (kGone - kWhole), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// False where they are all zero.
bool SmoothField::FillWeights(const std::array<std::int32_t, 3>& brick, Weights* filled) const {
  if (!sharp_edges_) return false;
  constexpr double kHalf = 0.5 * (kPoints - 1);
  const auto point = [&](double i, double j, double k) {
    return origin_ +
           cell_ * Vec3{brick[0] * kBrick + i, brick[1] * kBrick + j, brick[2] * kBrick + k};
  };
  const double around = (std::sqrt(3.0) * kHalf + kGone) * cell_;
  if (FindClosestPoint(*sharp_edges_, point(kHalf, kHalf, kHalf), around * around).slot < 0) {
    return false;
  }
  double* value = filled->values.data();
  for (int i = 0; i < kPoints; ++i) {
    for (int j = 0; j < kPoints; ++j) {
      for (int k = 0; k < kPoints; ++k) *value++ = WeightAt(point(i, j, k));
    }
  }
  filled->values.back() = 0;
  Kind* kind = filled->kind.data();
  for (int i = 0; i < kBrick; ++i) {
    for (int j = 0; j < kBrick; ++j) {
      for (int k = 0; k < kBrick; ++k) {
        double least = 1, most = 0;
        for (int n = 0; n < 27; ++n) {
          const int x = i + n / 9, y = j + n / 3 % 3, z = k + n % 3;
          const double weight = filled->values[(x * kPoints + y) * kPoints + z];
          least = std::min(least, weight), most = std::max(most, weight);
        }
        *kind++ = most == 0 ? Kind::kSpline : least == 1 ? Kind::kExact : Kind::kMixed;
      }
    }
  }
  return !AllAre(Kind::kSpline, *filled);
}

bool SmoothField::AllAre(Kind kind, const Weights& weights) {
  return std::ranges::all_of(weights.kind, [kind](Kind each) { return each == kind; });
}

// Null where nothing is kept (far outside, or when there are too many), or nothing is there and
// `make` is not set.
const SmoothField::Brick* SmoothField::FindBrick(const std::array<std::int32_t, 3>& brick,
                                                 bool make) const {
  const std::int64_t half = std::int64_t{1} << (kFanoutBits * levels_ - 1);  // of the tree's side
  std::array<std::int64_t, 3> at;
  for (int i = 0; i < 3; ++i) {
    at[i] = brick[i] + half;
    if (at[i] < 0 || at[i] >= 2 * half) return nullptr;
  }
  const Branch* branch = root_.get();
  for (int level = levels_ - 1;; --level) {
    std::int64_t child = 0;
    for (int i = 0; i < 3; ++i) {
      child = child << kFanoutBits | (at[i] >> (kFanoutBits * level) & (kFanout - 1));
    }
    if (level == 0) {
      const Lazy<Brick>& slot = branch->bricks[child];
      const Brick* found = slot.Peek();
      if (found || !make) return found;
      if (bricks_.fetch_add(1, std::memory_order_relaxed) >= kMostBricks) {
        bricks_.fetch_sub(1, std::memory_order_relaxed);
        return nullptr;
      }
      return &slot.Get([&] {
        auto* made = new Brick;
        auto weights = std::make_unique<Weights>();
        if (FillWeights(brick, weights.get())) made->weights = std::move(weights);
        if (!made->weights || !AllAre(Kind::kExact, *made->weights)) {
          made->spline = std::make_unique<Spline>();
          FillSpline(brick, made->spline.get());
        }
        return made;
      });
    }
    const Lazy<Branch>& slot = branch->branches[child];
    branch = make ? &slot.Get([&] { return new Branch(level - 1); }) : slot.Peek();
    if (!branch) return nullptr;
  }
}

SmoothField::Above SmoothField::IsAbove(const Vec3& p, double level, Cursor* cursor) const {
  std::array<std::int32_t, 3> brick;
  int cell = 0;
  for (int i = 0; i < 3; ++i) {
    const int base = LowestPoint((p[i] - origin_[i]) * inverse_cell_);
    brick[i] = base >> kBrickBits;
    cell = cell * kBrick + (base & (kBrick - 1));
  }
  if (brick != cursor->brick_ || !cursor->found_) {
    cursor->brick_ = brick;
    cursor->found_ = FindBrick(brick, false);
  }
  if (!cursor->found_) return Above::kUnknown;
  const Brick& found = *cursor->found_;
  if (found.weights && found.weights->kind[cell] != Kind::kSpline) return Above::kUnknown;
  return found.spline->least[cell] > level ? Above::kYes : Above::kMaybeNot;
}

double SmoothField::SharpDistance(const LatticeMemo::Point& point) const {
  const std::uint32_t value = sharp_distances_->ValueAt(point, [&] {
    const ClosestPoint closest = FindClosestPoint(*sharp_edges_, origin_ + point.offset);
    const double away = (1 + kFloatError) * std::sqrt(closest.squared_distance);
    return std::bit_cast<std::uint32_t>(static_cast<float>(away)) >> 2;
  });
  return std::bit_cast<float>(value << 2);
}

bool SmoothField::IsExact(const Vec3& center, double radius, double* doubt) const {
  if (!sharp_edges_) return false;
  LatticeMemo::Point point;
  if (!sharp_distances_->Next(center - origin_, 0.5 * radius, &point)) return false;
  *doubt = 2 * std::sqrt(0.75) * sharp_distances_->spacing(point.level) + 10 * kFloatError * cell_;
  const double away = SharpDistance(point) + std::sqrt(point.squared_distance);
  return away + radius < (kWhole - kWeighedFrom) * cell_;
}

double SmoothField::LeastSharpDistance(const Vec3& p, double spacing) const {
  if (!sharp_edges_) return std::numeric_limits<double>::infinity();
  LatticeMemo::Point point;
  if (!sharp_distances_->Next(p - origin_, spacing, &point)) return 0;
  return (1 - 2 * kFloatError) * SharpDistance(point) - std::sqrt(point.squared_distance);
}

bool SmoothField::MayBeExact(const Vec3& center, double radius, double way) const {
  return LeastSharpDistance(center, 0.5 * radius) - way + radius < (kWhole - kWeighedFrom) * cell_;
}

bool SmoothField::IsSpline(const Vec3& center, double radius) const {
  return LeastSharpDistance(center, cell_) - radius > (kGone + kWeighedFrom) * cell_;
}

double SmoothField::SafeWay(const Vec3& p, const Vec3& gradient, double above) const {
  const double sure = above / kSteepest;
  if (!(above > 0) || !IsSpline(p, cell_)) return sure;
  const double g = Norm(gradient), bend = kMostBend / cell_;
  const double way = 2 * above / (g + std::sqrt(g * g + 2 * bend * above));
  return std::max(sure, std::min(way, cell_));
}

FieldValue SmoothField::ProbeExact(const Vec3& p, Cursor* cursor) const {
  const FieldValue value = surface_->Probe(p, cursor->slot_);
  cursor->slot_ = value.slot;
  return value;
}

// What determines the field at a point.
struct SmoothField::Cell {
  struct Numbers {  // 27 of them: the first, and how far it is to the next along y and x
    const double* first;
    int row, plane;
  };
  SplineBasis basis;
  Kind kind;
  Numbers coefficients, weights;  // of a mixed cell both, else one of them or none
  double few[28], few_weights[28];
};

void SmoothField::Find(const Vec3& p, Cursor* cursor, Cell* cell) const {
  // Of the three basis functions over a cell, the middle one is centred on the closest lattice
  // point.
  std::array<std::int32_t, 3> base, brick;
  auto& [w, dw] = cell->basis;
  for (int i = 0; i < 3; ++i) {
    const double x = (p[i] - origin_[i]) * inverse_cell_;
    base[i] = LowestPoint(x);
    brick[i] = base[i] >> kBrickBits;
    const double t = x - (base[i] + 1);  // in [-1/2, 1/2]
    w[i][0] = 0.5 * (0.5 - t) * (0.5 - t), w[i][1] = 0.75 - t * t;
    w[i][2] = 0.5 * (0.5 + t) * (0.5 + t);
    dw[i][0] = t - 0.5, dw[i][1] = -2 * t, dw[i][2] = t + 0.5;
  }
  if (brick != cursor->brick_ || !cursor->found_) {
    cursor->brick_ = brick;
    cursor->found_ = FindBrick(brick, true);
  }
  if (const Brick* found = cursor->found_) {
    constexpr int kMask = kBrick - 1, kRow = kPoints, kPlane = kPoints * kPoints;
    const int x = base[0] & kMask, y = base[1] & kMask, z = base[2] & kMask;
    const int point = x * kPlane + y * kRow + z;
    cell->kind =
        found->weights ? found->weights->kind[(x * kBrick + y) * kBrick + z] : Kind::kSpline;
    if (found->spline)
      cell->coefficients = {found->spline->coefficients.data() + point, kRow, kPlane};
    if (found->weights) cell->weights = {found->weights->values.data() + point, kRow, kPlane};
    return;
  }
  Coefficients<3>(base, cell->few);
  cell->few[27] = cell->few_weights[27] = 0;
  cell->coefficients = {cell->few, 3, 9};
  cell->weights = {cell->few_weights, 3, 9};
  cell->kind = sharp_edges_ ? Kind::kMixed : Kind::kSpline;
  if (!sharp_edges_) return;
  for (int n = 0; n < 27; ++n) {
    const Vec3 at{base[0] + 1.0 * (n / 9), base[1] + 1.0 * (n / 3 % 3), base[2] + 1.0 * (n % 3)};
    cell->few_weights[n] = WeightAt(origin_ + cell_ * at);
  }
}

FieldValue SmoothField::Probe(const Vec3& p, Cursor* cursor) const {
  Cell cell;
  Find(p, cursor, &cell);
  if (cell.kind == Kind::kExact) return ProbeExact(p, cursor);
  const auto& [first, row, plane] = cell.coefficients;
  const SplineValue at = EvaluateSpline(cell.basis, first, row, plane);
  FieldValue smooth;
  smooth.phi = at.value;
  smooth.gradient = inverse_cell_ * at.slope;
  if (cell.kind == Kind::kSpline) return smooth;
  FieldValue mixed = ProbeExact(p, cursor);
  const SplineValue weight =
      EvaluateSpline(cell.basis, cell.weights.first, cell.weights.row, cell.weights.plane);
  const double more = mixed.phi - smooth.phi;
  mixed.phi = smooth.phi + weight.value * more;
  mixed.gradient = weight.value * mixed.gradient + (1 - weight.value) * smooth.gradient +
                   more * inverse_cell_ * weight.slope;
  return mixed;
}

Symmetric3 SmoothField::Curvature(const Vec3& p, Cursor* cursor) const {
  Cell cell;
  Find(p, cursor, &cell);
  Symmetric3 exact{};
  FieldValue value;
  if (cell.kind != Kind::kSpline) {
    value = ProbeExact(p, cursor);
    exact = surface_->Curvature(p, value);
    if (cell.kind == Kind::kExact) return exact;
  }
  const auto bent = [&](const Cell::Numbers& numbers) {
    Symmetric3 second = BendSpline(cell.basis, numbers.first, numbers.row, numbers.plane);
    const auto rounding = [this](double each) { return std::abs(each) < kFlatCell * cell_; };
    if (std::ranges::all_of(second, rounding)) return Symmetric3{};
    for (double& each : second) each *= inverse_cell_ * inverse_cell_;
    return second;
  };
  Symmetric3 second = bent(cell.coefficients);
  if (cell.kind == Kind::kSpline) {
    const auto rounding = [this](double each) {
      return std::abs(each) < kFlatCell * inverse_cell_;
    };
    return std::ranges::all_of(second, rounding) ? Symmetric3{} : second;
  }
  const auto evaluated = [&](const Cell::Numbers& numbers) {
    return EvaluateSpline(cell.basis, numbers.first, numbers.row, numbers.plane);
  };
  const SplineValue smooth = evaluated(cell.coefficients), weight = evaluated(cell.weights);
  const Symmetric3 of_weight = bent(cell.weights);
  const Vec3 more = value.gradient - inverse_cell_ * smooth.slope;
  const Vec3 slope = inverse_cell_ * weight.slope;
  const Symmetric3 across{2 * more.x * slope.x,
                          2 * more.y * slope.y,
                          2 * more.z * slope.z,
                          more.x * slope.y + more.y * slope.x,
                          more.x * slope.z + more.z * slope.x,
                          more.y * slope.z + more.z * slope.y};
  for (int i = 0; i < 6; ++i) {
    second[i] = weight.value * exact[i] + (1 - weight.value) * second[i] + across[i] +
                (value.phi - smooth.value) * of_weight[i];
  }
  return second;
}

}  // namespace contact_toolkit
