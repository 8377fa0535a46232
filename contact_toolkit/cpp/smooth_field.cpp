#include "smooth_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace contact_toolkit {
namespace {

// The first of the three lattice points whose basis functions reach x: the one before the closest.
std::int32_t LowestPoint(double x) {
  const auto truncated = static_cast<std::int32_t>(x + 0.5);
  return truncated - (x + 0.5 < truncated) - 1;
}

// Three numbers in a row, in pairs: GCC 12 splits wider vectors into single numbers where the CPU
// has none.
struct Line {
  using Pair = double __attribute__((vector_size(16)));

  Line() = default;
  explicit Line(const double* from) {  // reads one more
    std::memcpy(&low, from, sizeof low);
    std::memcpy(&high, from + 2, sizeof high);
  }
  double Times(const double* weight) const {
    return weight[0] * low[0] + weight[1] * low[1] + weight[2] * high[0];
  }

  Pair low, high;
};

Line Sum(const double* weight, const Line* lines) {
  Line sum;
  sum.low = weight[0] * lines[0].low + weight[1] * lines[1].low + weight[2] * lines[2].low;
  sum.high = weight[0] * lines[0].high + weight[1] * lines[1].high + weight[2] * lines[2].high;
  return sum;
}

}  // namespace

// A node of the tree over the bricks: of the lowest level it holds bricks, else branches.
struct SmoothField::Branch {
  static constexpr int kChildren = kFanout * kFanout * kFanout;
  explicit Branch(int level)
      : branches(level > 0 ? new FirstTouch<Branch>[kChildren] : nullptr),
        bricks(level > 0 ? nullptr : new FirstTouch<Brick>[kChildren]) {}
  std::unique_ptr<FirstTouch<Branch>[]> branches;
  std::unique_ptr<FirstTouch<Brick>[]> bricks;
};

SmoothField::SmoothField(std::shared_ptr<const ProbedSurface> surface, double cell)
    : surface_(std::move(surface)), cell_(cell), inverse_cell_(1 / cell) {
  const CollisionMesh& mesh = surface_->mesh();
  origin_ = 0.5 * (mesh.lower() + mesh.upper());
  // The tree covers the surface and as much again on either side.
  double covered = kBrick * kFanout * cell_;
  while (covered < 3 * mesh.diagonal()) covered *= kFanout, ++levels_;
  root_ = std::make_unique<Branch>(levels_ - 1);
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

void SmoothField::Fill(const std::array<std::int32_t, 3>& brick, Brick* filled) const {
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
      const FirstTouch<Brick>& slot = branch->bricks[child];
      const Brick* found = slot.Peek();
      if (found || !make) return found;
      if (bricks_.fetch_add(1, std::memory_order_relaxed) >= kMostBricks) {
        bricks_.fetch_sub(1, std::memory_order_relaxed);
        return nullptr;
      }
      return &slot.Get([&] {
        auto* made = new Brick;
        Fill(brick, made);
        return made;
      });
    }
    const FirstTouch<Branch>& slot = branch->branches[child];
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
  return cursor->found_->least[cell] > level ? Above::kYes : Above::kMaybeNot;
}

FieldValue SmoothField::Probe(const Vec3& p, Cursor* cursor) const {
  // Of the three basis functions over a cell, the middle one is centred on the closest lattice
  // point.
  std::array<std::int32_t, 3> base, brick;
  double w[3][3], dw[3][3];
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
  double few[3 * 3 * 3 + 1];
  const double* first;
  int row = kPoints, plane = kPoints * kPoints;
  if (cursor->found_) {
    constexpr int kMask = kBrick - 1;
    first = cursor->found_->coefficients.data() + (base[0] & kMask) * plane +
            (base[1] & kMask) * row + (base[2] & kMask);
  } else {
    Coefficients<3>(base, few);
    few[27] = 0;
    first = few, row = 3, plane = 9;
  }
  // Summed along x, y and z in turn.
  Line value_y[3], slope_y[3];
  for (int j = 0; j < 3; ++j) {
    const Line at[3] = {Line(first + j * row), Line(first + plane + j * row),
                        Line(first + 2 * plane + j * row)};
    value_y[j] = Sum(w[0], at);
    slope_y[j] = Sum(dw[0], at);
  }
  const Line value_z = Sum(w[1], value_y);
  FieldValue value;
  value.phi = value_z.Times(w[2]);
  value.gradient = inverse_cell_ * Vec3{Sum(w[1], slope_y).Times(w[2]),
                                        Sum(dw[1], value_y).Times(w[2]), value_z.Times(dw[2])};
  return value;
}

}  // namespace contact_toolkit
