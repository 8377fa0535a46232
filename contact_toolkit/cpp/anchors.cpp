#include "anchors.h"

#include <bit>
#include <utility>

namespace contact_toolkit {

AnchorSet::AnchorSet(std::vector<Anchor> anchors) : anchors_(std::move(anchors)) {
  slots_.assign(std::bit_ceil(2 * anchors_.size() + 1), -1);
  for (std::size_t i = 0; i < anchors_.size(); ++i) {
    std::size_t slot = SlotOf(anchors_[i].key);
    while (slots_[slot] >= 0) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = static_cast<std::int32_t>(i);
  }
}

std::int32_t AnchorSet::Search(std::uint64_t key) const {
  std::size_t slot = SlotOf(key);
  while (slots_[slot] >= 0 && anchors_[slots_[slot]].key != key) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  return slots_[slot];
}

std::size_t AnchorSet::SlotOf(std::uint64_t key) const {
  key *= 0x9E3779B97F4A7C15u;  // 2⁶⁴ over the golden ratio spreads neighbouring keys
  return (key ^ key >> 32) & (slots_.size() - 1);
}

}  // namespace contact_toolkit
