#include "swept.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "gjk.h"
#include "pair_advance.h"
#include "swept_search.h"
#include "tolerances.h"
#include "witness.h"

namespace contact_toolkit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// [m] What rounding alone can do to a distance between the two shapes.
double RoundingOf(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion) {
  const Vec3 start = motion.At(0).p, end = motion.At(1).p;
  return kTouching * (A.bvh().size + Norm(A.bvh().origin) + B.bvh().size + Norm(B.bvh().origin) +
                      std::max(Norm(start), Norm(end)));
}

// A pure translation carries a convex set over the hull of its two end positions: one GJK a pair.
class TranslationQuery {
 public:
  TranslationQuery(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                   double upper_bound)
      : A_(A),
        B_(B),
        start_(motion.At(0)),
        translation_(motion.translation()),
        still_(motion.still()) {
    best_.distance = upper_bound;
  }

  double reach(const TimeSlice&) const { return best_.distance > 0 ? best_.distance : -1; }
  Vec3 direction() const { return direction_; }

  void Visit(int slot_a, int slot_b, const TimeSlice&, double) {
    const auto a = A_.points(slot_a), b = B_.points(slot_b);
    swept_.resize(still_ ? b.size() : 2 * b.size());
    for (std::size_t i = 0; i < b.size(); ++i) {
      swept_[i] = start_ * b[i];
      if (!still_) swept_[b.size() + i] = swept_[i] + translation_;
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

  SweptDistance Answer() const {
    SweptDistance answer = best_;
    if (answer.index_a < 0) answer.distance = kInfinity;
    answer.lower_bound = std::min(answer.distance, lowest_);
    return answer;
  }

 private:
  const ConvexLeaves &A_, &B_;
  const Pose start_;
  const Vec3 translation_;
  const bool still_;
  std::vector<Vec3> swept_;
  Vec3 direction_;
  double lowest_ = kInfinity;  // of the pairs that GJK gave up on
  SweptDistance best_;
};

// With rotation: each pair is measured in the middle of a stretch of time, which proves it no
// closer than the least distance met so far less the tolerance for some time to either side; then
// the rest.
class RotationQuery {
 public:
  RotationQuery(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                double tolerance, double upper_bound)
      : A_(A), B_(B), motion_(motion), tolerance_(tolerance) {
    best_.distance = upper_bound;
  }

  double reach(const TimeSlice&) const { return best_.distance - tolerance_; }
  Vec3 direction() const { return direction_; }

  void Visit(int slot_a, int slot_b, const TimeSlice& slice, double bound) {
    open_.assign({{slice.begin, slice.end}});
    for (int i = 0; !open_.empty() && best_.distance > 0; ++i) {
      const auto [begin, end] = open_.back();
      open_.pop_back();
      const double s = 0.5 * (begin + end);
      const PairAt pair(A_.points(slot_a), B_.points(slot_b), motion_, s, &scratch_);
      direction_ = pair.gjk().normal;
      if (pair.gjk().distance < best_.distance) Keep(slot_a, slot_b, s, pair.gjk());
      const double reach = best_.distance - tolerance_;
      const double forward = pair.SafeStep(reach, 1), backward = pair.SafeStep(reach, -1);
      if (i == kAdvanceSteps || forward + backward == 0) {
        best_.converged = false;
        lowest_ = std::min(lowest_, bound);
        return;
      }
      // What neither step covers, the nearer side last: it is searched first.
      const std::pair later{s + forward, end}, earlier{begin, s - backward};
      for (const auto& part :
           pair.approaching() ? std::array{earlier, later} : std::array{later, earlier}) {
        if (part.first < part.second) open_.push_back(part);
      }
    }
  }

  SweptDistance Answer() const {
    SweptDistance answer = best_;
    if (answer.index_a < 0) answer.distance = kInfinity;
    answer.lower_bound = std::max(0.0, std::min(answer.distance - tolerance_, lowest_));
    return answer;
  }

 private:
  void Keep(int slot_a, int slot_b, double s, const GjkResult& gjk) {
    best_.distance = gjk.distance;
    best_.time = s;
    best_.p_ACa = gjk.p_A, best_.p_ACb = gjk.p_B;
    best_.index_a = A_.index(slot_a), best_.index_b = B_.index(slot_b);
  }

  const ConvexLeaves &A_, &B_;
  const Motion& motion_;
  const double tolerance_;
  std::vector<Vec3> scratch_;
  Vec3 direction_;
  std::vector<std::pair<double, double>> open_;  // stretches of time not yet covered
  double lowest_ = kInfinity;                    // of the pairs given up on
  SweptDistance best_;
};

class ImpactQuery {
 public:
  // any_time: the first impact found will do, it need not be the earliest.
  ImpactQuery(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion, double separation,
              double tolerance, bool any_time)
      : A_(A),
        B_(B),
        motion_(motion),
        separation_(separation),
        tolerance_(tolerance),
        any_time_(any_time) {}

  double reach(const TimeSlice& slice) const { return slice.begin < end_ ? separation_ : -1; }
  Vec3 direction() const { return direction_; }

  void Visit(int slot_a, int slot_b, const TimeSlice& slice, double) {
    double s = slice.begin;
    for (int i = 0; s < end_; ++i) {
      const PairAt pair(A_.points(slot_a), B_.points(slot_b), motion_, s, &scratch_);
      direction_ = pair.gjk().normal;
      const bool reached = pair.gjk().distance <= separation_ + tolerance_;
      const double step = reached ? 0 : pair.SafeStep(separation_, 1);
      if (s + step == s || i == kAdvanceSteps) {
        Keep(slot_a, slot_b, s, pair.gjk(), reached);
        return;
      }
      s += step;
      if (s >= slice.end) return;
    }
  }

  const TimeOfImpact& answer() const { return best_; }

 private:
  void Keep(int slot_a, int slot_b, double s, const GjkResult& gjk, bool reached) {
    end_ = any_time_ ? -1 : s;
    best_.time = s;
    best_.distance = gjk.distance;
    best_.p_ACa = gjk.p_A, best_.p_ACb = gjk.p_B;
    best_.normal_A = Normalized(gjk.p_A - gjk.p_B);
    best_.index_a = A_.index(slot_a), best_.index_b = B_.index(slot_b);
    best_.status = !reached ? ImpactStatus::kIterationLimit
                   : s == 0 ? ImpactStatus::kInitialContact
                            : ImpactStatus::kImpact;
  }

  const ConvexLeaves &A_, &B_;
  const Motion& motion_;
  const double separation_, tolerance_;
  const bool any_time_;
  std::vector<Vec3> scratch_;
  Vec3 direction_;
  double end_ = 2;  // nothing from here on matters
  TimeOfImpact best_;
};

TimeOfImpact FindImpact(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                        double separation, double tolerance, bool any_time) {
  ImpactQuery query(A, B, motion, separation, std::max(tolerance, RoundingOf(A, B, motion)),
                    any_time);
  SweptSearch(A, B, motion, true, &query).Run();
  return query.answer();
}

}  // namespace

SweptDistance FindSweptDistance(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                                double tolerance, double upper_bound) {
  if (motion.still() && A.mesh() != nullptr && B.mesh() != nullptr) {
    const ClosestPair pair = FindDistance(*A.mesh(), *B.mesh(), motion.At(0), upper_bound);
    return {pair.distance, pair.distance, 0,   pair.p_ACa, pair.p_ACb,
            pair.facet_a,  pair.facet_b,  true};
  }
  if (!motion.rotates()) {
    TranslationQuery query(A, B, motion, upper_bound);
    SweptSearch(A, B, motion, false, &query).Run();
    return query.Answer();
  }
  RotationQuery query(A, B, motion, std::max(tolerance, RoundingOf(A, B, motion)), upper_bound);
  SweptSearch(A, B, motion, true, &query).Run();
  return query.Answer();
}

TimeOfImpact FindTimeOfImpact(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                              double separation, double tolerance) {
  return FindImpact(A, B, motion, separation, tolerance, false);
}

bool SweptIntersects(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                     double tolerance) {
  if (motion.still() && A.mesh() != nullptr && B.mesh() != nullptr) {
    return Intersects(*A.mesh(), *B.mesh(), motion.At(0));
  }
  if (!motion.rotates()) {
    const double rounding = RoundingOf(A, B, motion);
    return FindSweptDistance(A, B, motion, tolerance, rounding).distance <= rounding;
  }
  return FindImpact(A, B, motion, 0, tolerance, true).status != ImpactStatus::kFree;
}

}  // namespace contact_toolkit
