#include "translation_query.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "node_extents.h"
#include "tolerances.h"

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Of A (0) and of B (1).
NodeExtents& Extents(int side) {
  thread_local NodeExtents extents[2];
  return extents[side];
}

}  // namespace

TranslationQuery::TranslationQuery(const ConvexLeaves& A, const ConvexLeaves& B,
                                   const Motion& motion, double upper_bound)
    : A_(A),
      B_(B),
      motion_(motion),
      meshes_(A.mesh() != nullptr && B.mesh() != nullptr),
      lowest_(kInfinity),
      aimed_at_(kInfinity) {
  best_.distance = upper_bound;
  best_.time = 0.5;
}

bool TranslationQuery::Apart(std::int32_t node_a, std::int32_t node_b) {
  if (!meshes_ || best_.index_a < 0) return false;
  if (best_.distance < kStaleAim * aimed_at_) Aim();
  const float apart = Extents(0).Least(node_a) + Extents(1).Least(node_b) - offset_;
  return apart > best_.distance * (1 + kCullingSlack);
}

void TranslationQuery::Aim() {
  aimed_at_ = best_.distance;
  const Bvh &a = A_.bvh(), &b = B_.bvh();
  const Pose start = motion_.At(0);
  const Vec3 line = Normalized(best_.p_ACa - best_.p_ACb);
  const Vec3 line_B = -(Transpose(start.R) * line);
  const float n[3]{static_cast<float>(line.x), static_cast<float>(line.y),
                   static_cast<float>(line.z)};
  const float n_B[3]{static_cast<float>(line_B.x), static_cast<float>(line_B.y),
                     static_cast<float>(line_B.z)};
  Extents(0).Start(a, n);
  Extents(1).Start(b, n_B);
  const Vec3 begin = start * b.origin - a.origin, end = begin + motion_.translation();
  const double slack = kCullingSlack * (a.size + b.size + std::max(Norm(begin), Norm(end)));
  offset_ = static_cast<float>(std::max(Dot(line, begin), Dot(line, end)) + slack);
}

void TranslationQuery::Visit(const LeafPairs& pairs, const TimeSlice& whole) {
  if (meshes_) MeasurePosed(pairs);
  for (int i = 0; i < pairs.count; ++i) {
    const LeafPairs::Pair& pair = pairs.pair[i];
    if (!(pair.squared_bound <= squared_reach(whole))) return;
    if (meshes_ && LowerBound(i) > best_.distance) continue;
    MeasureSwept(pair.slot_a, pair.slot_b);
  }
}

void TranslationQuery::MeasurePosed(const LeafPairs& pairs) {
  if (posed_time_ != best_.time) {
    posed_time_ = best_.time;
    posed_ = std::make_unique<const PosedPair>(*A_.mesh(), *B_.mesh(), motion_.At(posed_time_));
  }
  chunk_.count = pairs.count;
  for (int i = 0; i < pairs.count; ++i) {
    chunk_.slot_a[i] = pairs.pair[i].slot_a;
    chunk_.slot_b[i] = pairs.pair[i].slot_b;
  }
  MeasureFacetPairs(*posed_, &chunk_);
  const auto least = std::min_element(chunk_.distance, chunk_.distance + chunk_.count);
  if (!(*least < best_.distance)) return;
  const int i = static_cast<int>(least - chunk_.distance);
  const Witness witness = WitnessOf(*posed_, chunk_, i);
  best_.distance = witness.distance;
  best_.p_ACa = witness.p_ACa, best_.p_ACb = witness.p_ACb;
  best_.index_a = A_.index(chunk_.slot_a[i]), best_.index_b = B_.index(chunk_.slot_b[i]);
  direction_ = witness.normal_A;
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
  best_.index_a = A_.index(slot_a), best_.index_b = B_.index(slot_b);
}

SweptDistance TranslationQuery::Answer() const {
  SweptDistance answer = best_;
  if (answer.index_a < 0) answer.distance = kInfinity;
  answer.lower_bound = std::min(answer.distance, lowest_);
  return answer;
}

}  // namespace contact_toolkit
