#include "base/column.h"

#include <algorithm>
#include <bit>
#include <mutex>

#if __linux__
#include <sys/mman.h>
#endif

namespace contact_toolkit {
namespace {

constexpr std::size_t kSmallest = 1 << 8, kMostHeld = 1 << 27;  // [bytes]
constexpr std::align_val_t kCacheLine{64};  // vectors that straddle lines cost two loads

constexpr std::size_t kHugePage = 1 << 21;  // [bytes] takes one entry of the address cache, not 512

std::size_t SizeOf(std::size_t bytes) { return std::bit_ceil(std::max(bytes, kSmallest)); }

std::align_val_t AlignmentOf(std::size_t size) {
  return size < kHugePage ? kCacheLine : std::align_val_t{kHugePage};
}

void* NewBlock(std::size_t size) {
  void* block = ::operator new(size, AlignmentOf(size));
#if __linux__
  if (size >= kHugePage) madvise(block, size, MADV_HUGEPAGE);
#endif
  return block;
}

struct Stock {
  std::mutex mutex;
  std::vector<void*> blocks[64];  // by the logarithm of their size
  std::size_t held = 0;
};

// Never destroyed: arrays may outlive every other object of the process.
Stock& TheStock() {
  static auto* stock = new Stock;
  return *stock;
}

}  // namespace

void* TakeBlock(std::size_t bytes) {
  const std::size_t size = SizeOf(bytes);
  Stock& stock = TheStock();
  {
    const std::lock_guard lock(stock.mutex);
    std::vector<void*>& blocks = stock.blocks[std::countr_zero(size)];
    if (!blocks.empty()) {
      void* block = blocks.back();
      blocks.pop_back();
      stock.held -= size;
      return block;
    }
  }
  return NewBlock(size);
}

void GiveBlock(void* block, std::size_t bytes) noexcept {
  const std::size_t size = SizeOf(bytes);
  Stock& stock = TheStock();
  {
    const std::lock_guard lock(stock.mutex);
    if (stock.held + size <= kMostHeld) {
      stock.blocks[std::countr_zero(size)].push_back(block);
      stock.held += size;
      return;
    }
  }
  ::operator delete(block, AlignmentOf(size));
}

}  // namespace contact_toolkit
