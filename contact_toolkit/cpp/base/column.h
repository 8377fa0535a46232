// A column of results: a vector whose new elements are not set, for the query writes each once, and
// whose blocks are kept for the next query: a fresh one costs a page fault every 4 kB.
#pragma once

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace contact_toolkit {

// Blocks in sizes of powers of two from 256 B; up to 128 MB lie in wait. Thread-safe.
void* TakeBlock(std::size_t bytes);
void GiveBlock(void* block, std::size_t bytes) noexcept;

template <class T>
struct ColumnAllocator {
  using value_type = T;
  ColumnAllocator() = default;
  template <class U>
  ColumnAllocator(const ColumnAllocator<U>&) {}

  T* allocate(std::size_t n) { return static_cast<T*>(TakeBlock(n * sizeof(T))); }
  void deallocate(T* block, std::size_t n) noexcept { GiveBlock(block, n * sizeof(T)); }
  template <class U, class... Args>
  void construct(U* p, Args&&... args) {
    if constexpr (sizeof...(Args) > 0) ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }
  bool operator==(const ColumnAllocator&) const { return true; }
};

template <class T>
using Column = std::vector<T, ColumnAllocator<T>>;

}  // namespace contact_toolkit
