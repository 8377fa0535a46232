// The earliest time at which a pair of leaves comes as close as a separation. Boxes swept up to a
// late time are wide and touch where the leaves do not: each time the impact known has come forward
// to half of what is being searched, the search starts anew on what is left.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/tolerances.h"
#include "query/swept/pair_advance.h"
#include "query/swept/swept.h"
#include "query/swept/swept_search.h"

namespace contact_toolkit {

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

  // Whether something is left to search; then up to time `end()`.
  bool Restart() {
    if (!(end_ > 0 && end_ < horizon_ / 2)) return false;
    horizon_ = end_;
    return true;
  }
  double end() const { return horizon_; }

  double squared_reach(const TimeSlice& slice) const {
    return end_ >= horizon_ / 2 && slice.begin < end_ ? separation_ * separation_ : -1;
  }
  Vec3 direction() const { return direction_; }

  void Visit(const LeafPairs& pairs, const TimeSlice& slice) {
    for (int i = 0; i < pairs.count; ++i)
      Advance(pairs.pair[i].slot_a, pairs.pair[i].slot_b, slice);
  }

  const TimeOfImpact& answer() const { return best_; }

 private:
  void Advance(int slot_a, int slot_b, const TimeSlice& slice) {
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

  void Keep(int slot_a, int slot_b, double s, const GjkResult& gjk, bool reached) {
    end_ = any_time_ ? -1 : s;
    best_.time = s;
    best_.distance = gjk.distance;
    best_.p_ACa = gjk.p_A, best_.p_ACb = gjk.p_B;
    best_.normal_A = Normalized(gjk.p_A - gjk.p_B);
    best_.facet_a = A_.index(slot_a), best_.facet_b = B_.index(slot_b);
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
  double horizon_ = 1;  // of the search that is going on
  double end_ = 2;      // nothing from here on matters
  TimeOfImpact best_;
};

}  // namespace contact_toolkit
