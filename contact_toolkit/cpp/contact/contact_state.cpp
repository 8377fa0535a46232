#include "contact/contact_state.h"

#include <algorithm>
#include <atomic>
#include <span>

namespace contact_toolkit {

PairState ContactState::StateOf(int pair) const {
  const auto it = std::ranges::lower_bound(pairs, pair, {}, &PairState::pair);
  return it != pairs.end() && it->pair == pair ? *it : PairState{pair, nullptr, nullptr};
}

const PairSprings* ContactState::SpringsOf(int pair) const {
  if (!forces) return nullptr;
  const std::span known(forces->loaded->pairs.data(), forces->loaded->size);
  const auto it = std::ranges::lower_bound(known, pair, {}, &PairSprings::pair);
  return it != known.end() && it->pair == pair && it->springs.size() > 0 ? &*it : nullptr;
}

const Separation* ContactState::SeparationOf(int pair) const {
  const auto it = std::ranges::lower_bound(separations, pair, {}, &Separation::pair);
  return it != separations.end() && it->pair == pair ? &*it : nullptr;
}

std::uint64_t NewStateId() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace contact_toolkit
