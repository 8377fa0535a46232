// A hash table from feature pairs to rows, emptied between queries without being freed.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace contact_toolkit {

class MergeTable {
 public:
  void Clear() {
    if (used_ > 0) entries_.assign(entries_.size(), Entry{});
    used_ = 0;
  }

  // The row kept under a key, -1 when there is none yet; valid until the next call.
  std::int32_t* Find(std::uint64_t key) {
    if (2 * (used_ + 1) > entries_.size()) Grow();
    Entry* entry = Slot(key);
    if (entry->key != key) {
      entry->key = key;
      ++used_;
    }
    return &entry->row;
  }

 private:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};
  struct Entry {
    std::uint64_t key = kEmpty;
    std::int32_t row = -1;
  };

  Entry* Slot(std::uint64_t key) {
    const std::size_t mask = entries_.size() - 1;
    std::size_t at = (key * 0x9e3779b97f4a7c15ull >> 32) & mask;
    while (entries_[at].key != kEmpty && entries_[at].key != key) at = (at + 1) & mask;
    return &entries_[at];
  }

  void Grow() {
    std::vector<Entry> old(entries_.empty() ? 1024 : 2 * entries_.size());
    std::swap(old, entries_);
    for (const Entry& entry : old) {
      if (entry.key != kEmpty) *Slot(entry.key) = entry;
    }
  }

  std::vector<Entry> entries_;
  std::size_t used_ = 0;
};

}  // namespace contact_toolkit
