// A hash table from feature pairs to rows, emptied between queries at no cost: a small query
// after a large one must not pay for its table.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace contact_toolkit {

class MergeTable {
 public:
  void Clear() {
    used_ = 0;
    if (++query_ == 0) entries_.assign(entries_.size(), Entry{}), query_ = 1;
  }

  // Fetches what Find() will look at, some calls ahead.
  void Prefetch(std::uint64_t key) const {
    if (!entries_.empty()) __builtin_prefetch(&entries_[Home(key)]);
  }

  // The row kept under a key that has been looked for before, null when it has not.
  std::int32_t* Known(std::uint64_t key) {
    if (used_ == 0) return nullptr;
    Entry* entry = Slot(key);
    return entry->query == query_ ? &entry->row : nullptr;
  }

  // The row kept under a key, -1 when there is none yet; valid until the next call.
  std::int32_t* Find(std::uint64_t key) {
    if (2 * (used_ + 1) > entries_.size()) Grow();
    Entry* entry = Slot(key);
    if (entry->query != query_) {
      *entry = {key, -1, query_};
      ++used_;
    }
    return &entry->row;
  }

 private:
  struct Entry {
    std::uint64_t key = 0;
    std::int32_t row = -1;
    std::uint32_t query = 0;  // the one that filled it; other than the current one: empty
  };

  std::size_t Home(std::uint64_t key) const {
    return (key * 0x9e3779b97f4a7c15ull >> 32) & (entries_.size() - 1);
  }

  Entry* Slot(std::uint64_t key) {
    const std::size_t mask = entries_.size() - 1;
    std::size_t at = Home(key);
    while (entries_[at].query == query_ && entries_[at].key != key) at = (at + 1) & mask;
    return &entries_[at];
  }

  void Grow() {
    std::vector<Entry> old(entries_.empty() ? 1024 : 2 * entries_.size());
    std::swap(old, entries_);
    for (const Entry& entry : old) {
      if (entry.query == query_) *Slot(entry.key) = entry;
    }
  }

  std::vector<Entry> entries_;
  std::size_t used_ = 0;
  std::uint32_t query_ = 1;
};

}  // namespace contact_toolkit
