#include "query/swept/translation_query.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <utility>

#include "base/tolerances.h"
#include "query/witness/nearest_search.h"

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// [-] A way longer than this many halves of the smaller body passes by rather than sets out.
constexpr double kPassing = 1;
// Pairs of facets are culled again once the distance has fallen to this fraction,
constexpr double kStaleCull = 0.95;
// ... unless so few are left that measuring them is as cheap.
constexpr int kFewPairs = 2;
// Of so few pairs the tangents tell most, and sooner than planes.
constexpr int kFewToPose = 8;

LineCull LineCullOf(const Bvh& a, const Bvh& b, const Motion& motion) {
  const Pose start = motion.At(0);
  const Vec3 begin = start * b.origin - a.origin, end = begin + motion.translation();
  return {a, b, start.R, begin, end, kTouching * std::max(Norm(begin), Norm(end))};
}

}  // namespace

TranslationQuery::TranslationQuery(const ConvexLeaves& A, const ConvexLeaves& B,
                                   const Motion& motion, double upper_bound)
    : A_(A),
      B_(B),
      motion_(motion),
      meshes_(A.mesh() != nullptr && B.mesh() != nullptr),
      cull_(A.bvh(), B.bvh(), motion, TimeSlices(motion, 1)[0]),
      line_cull_(LineCullOf(A.bvh(), B.bvh(), motion)),
      lowest_(kInfinity) {
  best_.distance = upper_bound;
  // To begin with, the start; but of a long way, when the bodies' middles are closest.
  const Vec3 from = motion.At(0) * B.bvh().origin - A.bvh().origin, &way = motion.translation();
  if (Norm(way) > kPassing * std::min(A.bvh().size, B.bvh().size)) {
    best_.time = std::clamp(-Dot(from, way) / SquaredNorm(way), 0.0, 1.0);
  }
  if (meshes_) start_.emplace(*A.mesh(), *B.mesh(), motion.At(0));
}

void TranslationQuery::Run() {
  NearestSearch(A_.bvh(), B_.bvh(), this).Run();
  Finish();
}

const PosedPair& TranslationQuery::Posed() {
  if (posed_time_ != best_.time) {
    posed_time_ = best_.time;
    posed_.emplace(*A_.mesh(), *B_.mesh(), motion_.At(posed_time_));
  }
  return *posed_;
}

std::uint64_t TranslationQuery::Orders(const BvhNode& a, const BvhNode& b, float* bound,
                                       float* order) {
  if (at_time_ != best_.time) {
    at_time_ = best_.time;
    const Vec3 at = cull_.begin.p + at_time_ * (cull_.end.p - cull_.begin.p);
    for (int i = 0; i < 3; ++i) at_[i] = static_cast<float>(at[i]);
  }
  return kernels_.translation_orders(a, b, cull_, at_, Limit(), kMiddles, bound, order);
}

std::uint64_t TranslationQuery::Cull(const BvhNode& a, const BvhNode& b,
                                     std::uint64_t pairs) const {
  if (!meshes_) return pairs;
  const Vec3 n = A_.bvh().axes * direction_;
  const float direction[3]{static_cast<float>(n.x), static_cast<float>(n.y),
                           static_cast<float>(n.z)};
  return kernels_.cull_facets(A_.bvh().blocks[a.block], B_.bvh().blocks[b.block], cull_, direction,
                              static_cast<float>(best_.distance), pairs);
}

void TranslationQuery::Measure(const BvhNode& a, const BvhNode& b, std::uint64_t pairs) {
  chunk_.count = 0;
  for (; pairs != 0; pairs &= pairs - 1) {
    const int pair = std::countr_zero(pairs);
    chunk_.slot_a[chunk_.count] = a.child[pair & 7];
    chunk_.slot_b[chunk_.count] = b.child[pair >> 3];
    bound_[chunk_.count++] = 0;
  }
  if (meshes_) return MeasureFacets();
  for (int i = 0; i < chunk_.count; ++i) MeasureSwept(chunk_.slot_a[i], chunk_.slot_b[i]);
}

void TranslationQuery::MeasureFacets() {
  if (chunk_.count <= kFewToPose) {
    MeasurePosed();
    PutLeastLast();
  } else if (best_.facet_a >= 0) {
    CullPrisms();
    MeasurePosed();
  } else {
    MeasurePosed();
    CullPrisms();
  }
  if (chunk_.count == 0 || !(best_.distance > 0)) return;
  MeasureLast();
  for (int i = 0; i < chunk_.count; ++i) {
    if (!(bound_[i] < ToBeat())) continue;
    put_off_.slot_a[put_off_.count] = chunk_.slot_a[i];
    put_off_.slot_b[put_off_.count] = chunk_.slot_b[i];
    put_off_.bound[put_off_.count++] = bound_[i];
  }
  if (put_off_.count + kBvhWidth * kBvhWidth > FacetPairs::kCapacity) Finish();
}

void TranslationQuery::PutLeastLast() {
  if (chunk_.count == 0) return;
  const int last = chunk_.count - 1;
  const auto least = std::min_element(bound_.begin(), bound_.begin() + chunk_.count);
  const auto i = least - bound_.begin();
  std::swap(bound_[i], bound_[last]);
  std::swap(chunk_.slot_a[i], chunk_.slot_a[last]);
  std::swap(chunk_.slot_b[i], chunk_.slot_b[last]);
}

void TranslationQuery::MeasureLast() {
  const int last = --chunk_.count;
  if (bound_[last] < ToBeat()) MeasureSwept(chunk_.slot_a[last], chunk_.slot_b[last]);
}

void TranslationQuery::Finish() {
  chunk_.count = put_off_.count;
  std::copy_n(put_off_.slot_a.begin(), put_off_.count, chunk_.slot_a);
  std::copy_n(put_off_.slot_b.begin(), put_off_.count, chunk_.slot_b);
  std::copy_n(put_off_.bound.begin(), put_off_.count, bound_.begin());
  put_off_.count = 0;
  double culled_at = kInfinity;
  while (chunk_.count > 0 && best_.distance > 0) {
    if (chunk_.count > kFewPairs && best_.distance < kStaleCull * culled_at) {
      culled_at = best_.distance;
      CullPrisms();
    } else {
      MeasureLast();
    }
  }
}

double TranslationQuery::ToBeat() const {
  return best_.distance - std::min(kTouching * start_->size, 0.5 * best_.distance);
}

void TranslationQuery::CullPrisms() {
  if (chunk_.count == 0) return;
  const Vec3& t = motion_.translation();
  const double way[3]{t.x, t.y, t.z};
  const double line[3]{line_.x, line_.y, line_.z};
  kernels_.cull_prisms(A_.bvh().slot_coordinates.data(), B_.bvh().slot_coordinates.data(),
                       start_->matrix, way, line, ToBeat(), &chunk_);
  struct Left {
    double estimate, bound;
    std::int32_t slot_a, slot_b;
  };
  std::array<Left, FacetPairs::kCapacity> left;
  int kept = 0;
  for (int i = 0; i < chunk_.count; ++i) {
    if (chunk_.distance[i] < 0) continue;
    left[kept++] = {chunk_.distance[i], bound_[i], chunk_.slot_a[i], chunk_.slot_b[i]};
  }
  std::sort(left.begin(), left.begin() + kept,
            [](const Left& x, const Left& y) { return x.estimate > y.estimate; });
  for (int i = 0; i < kept; ++i) {
    chunk_.slot_a[i] = left[i].slot_a;
    chunk_.slot_b[i] = left[i].slot_b;
    bound_[i] = left[i].bound;
  }
  chunk_.count = kept;
}

void TranslationQuery::MeasurePosed() {
  if (chunk_.count == 0) return;
  MeasureFacetPairs(Posed(), &chunk_);
  const auto least = std::min_element(chunk_.distance, chunk_.distance + chunk_.count);
  if (*least < best_.distance) {
    const int i = static_cast<int>(least - chunk_.distance);
    const Witness witness = WitnessOf(*posed_, chunk_, i);
    best_.distance = witness.distance;
    best_.p_ACa = witness.p_ACa, best_.p_ACb = witness.p_ACb;
    best_.facet_a = A_.index(chunk_.slot_a[i]), best_.facet_b = B_.index(chunk_.slot_b[i]);
    direction_ = line_ = witness.normal_A;
  }
  int kept = 0;
  for (int i = 0; i < chunk_.count; ++i) {
    const double bound = LowerBound(i);
    if (bound > best_.distance) continue;
    bound_[kept] = bound;
    chunk_.slot_a[kept] = chunk_.slot_a[i];
    chunk_.slot_b[kept++] = chunk_.slot_b[i];
  }
  chunk_.count = kept;
}

double TranslationQuery::LowerBound(int i) const {
  const double distance = chunk_.distance[i];
  const Vec3 normal{chunk_.normal[0][i], chunk_.normal[1][i], chunk_.normal[2][i]};
  const double closing = Dot(normal, motion_.translation());  // [m] over the whole way
  const double closer = std::max(closing * (1 - posed_time_), -closing * posed_time_);
  const double rounding = Norm(motion_.translation()) * kTouching * posed_->size / distance;
  return distance - closer - rounding;
}

void TranslationQuery::MeasureSwept(int slot_a, int slot_b) {
  const auto a = A_.points(slot_a), b = B_.points(slot_b);
  swept_.clear();
  const Pose start = motion_.At(0);
  for (const Vec3& p : b) swept_.push_back(start * p);
  if (!motion_.still()) {
    for (std::size_t i = 0; i < b.size(); ++i) swept_.push_back(swept_[i] + motion_.translation());
  }
  const GjkResult gjk = Gjk(a, swept_, best_.distance, direction_);
  direction_ = gjk.normal;
  if (gjk.status == GjkStatus::kIterationLimit) {
    best_.converged = false;
    lowest_ = std::min(lowest_, gjk.lower_bound);
  }
  if (gjk.status == GjkStatus::kBeyondBound || !(gjk.distance < best_.distance)) return;
  double time = 0;
  for (int k = 0; k < gjk.count; ++k) {
    if (gjk.index_b[k] >= static_cast<int>(b.size())) time += gjk.weight[k];
  }
  best_.distance = gjk.distance;
  best_.time = std::min(time, 1.0);
  best_.p_ACa = gjk.p_A, best_.p_ACb = gjk.p_B;
  line_ = gjk.normal;
  best_.facet_a = A_.index(slot_a), best_.facet_b = B_.index(slot_b);
}

SweptDistance TranslationQuery::Answer() const {
  SweptDistance answer = best_;
  if (answer.facet_a < 0) answer.distance = kInfinity;
  answer.lower_bound = std::min(answer.distance, lowest_);
  return answer;
}

}  // namespace contact_toolkit
