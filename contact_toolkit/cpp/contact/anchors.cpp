#include "contact/anchors.h"

#include <bit>

namespace contact_toolkit {
namespace {

// Where to look first in a table of this length, a power of two.
std::size_t SlotOf(std::uint64_t key, std::size_t length) {
  key *= 0x9E3779B97F4A7C15u;  // 2⁶⁴ over the golden ratio spreads neighbouring keys
  return (key ^ key >> 32) & (length - 1);
}

}  // namespace

AnchorSet::Slots* AnchorSet::MakeSlots() const {
  auto* slots = new Slots(std::bit_ceil(2 * anchors_.size() + 1), -1);
  for (std::size_t i = 0; i < anchors_.size(); ++i) {
    std::size_t slot = SlotOf(anchors_[i].key, slots->size());
    while ((*slots)[slot] >= 0) slot = (slot + 1) & (slots->size() - 1);
    (*slots)[slot] = static_cast<std::int32_t>(i);
  }
  return slots;
}

std::int32_t AnchorSet::Search(std::uint64_t key) const {
  const Slots& slots = slots_.Get([this] { return MakeSlots(); });
  std::size_t slot = SlotOf(key, slots.size());
  while (slots[slot] >= 0 && anchors_[slots[slot]].key != key) {
    slot = (slot + 1) & (slots.size() - 1);
  }
  return slots[slot];
}

}  // namespace contact_toolkit
