// Least distance over a motion with rotation.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/tolerances.h"
#include "query/swept/pair_advance.h"
#include "query/swept/swept.h"
#include "query/swept/swept_search.h"
#include "query/witness/witness.h"

namespace contact_toolkit {

// Each pair is measured in the middle of a stretch of time, which proves it no
// closer than the least distance met so far less the tolerance for some time to either side; then
// the rest.
class RotationQuery {
 public:
  RotationQuery(const ConvexLeaves& A, const ConvexLeaves& B, const Motion& motion,
                double tolerance, double upper_bound)
      : A_(A), B_(B), motion_(motion), tolerance_(tolerance) {
    best_.distance = upper_bound + tolerance;  // so that nothing below the bound goes unseen
  }

  // Takes over what a static query found at a time: the better the distance known beforehand, the
  // less there is to search.
  void Start(double s, const ClosestPair& pair) {
    if (!(pair.distance < best_.distance)) return;
    best_.distance = pair.distance;
    best_.time = s;
    best_.p_ACa = pair.p_ACa, best_.p_ACb = pair.p_ACb;
    best_.facet_a = pair.facet_a, best_.facet_b = pair.facet_b;
  }
  double distance() const { return best_.distance; }  // [m] up to which pairs matter

  double squared_reach(const TimeSlice&) const {
    const double reach = best_.distance - tolerance_;
    return reach >= 0 ? reach * reach : -1;
  }
  Vec3 direction() const { return direction_; }

  void Visit(const LeafPairs& pairs, const TimeSlice& slice) {
    for (int i = 0; i < pairs.count; ++i) {
      const auto [squared_bound, slot_a, slot_b] = pairs.pair[i];
      if (squared_bound > squared_reach(slice)) return;
      Advance(slot_a, slot_b, slice, std::sqrt(squared_bound));
    }
  }

  SweptDistance Answer() const {
    SweptDistance answer = best_;
    if (answer.facet_a < 0) answer.distance = std::numeric_limits<double>::infinity();
    answer.lower_bound = std::max(0.0, std::min(answer.distance - tolerance_, lowest_));
    return answer;
  }

 private:
  // Covers the slice for one pair, which is no closer in it than `bound`.
  void Advance(int slot_a, int slot_b, const TimeSlice& slice, double bound) {
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

  void Keep(int slot_a, int slot_b, double s, const GjkResult& gjk) {
    best_.distance = gjk.distance;
    best_.time = s;
    best_.p_ACa = gjk.p_A, best_.p_ACb = gjk.p_B;
    best_.facet_a = A_.index(slot_a), best_.facet_b = B_.index(slot_b);
  }

  const ConvexLeaves &A_, &B_;
  const Motion& motion_;
  const double tolerance_;
  std::vector<Vec3> scratch_;
  Vec3 direction_;
  std::vector<std::pair<double, double>> open_;              // stretches of time not yet covered
  double lowest_ = std::numeric_limits<double>::infinity();  // of the pairs given up on
  SweptDistance best_;
};

}  // namespace contact_toolkit
