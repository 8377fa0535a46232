// A value computed by whichever thread needs it first, without locks. The computation must be a
// pure function: when two threads race, one result is thrown away, and it must not matter which.
#pragma once

#include <atomic>

namespace contact_toolkit {

template <typename T>
class Lazy {
 public:
  Lazy() = default;
  Lazy(const Lazy&) = delete;
  Lazy& operator=(const Lazy&) = delete;
  ~Lazy() { delete value_.load(std::memory_order_relaxed); }

  // Null until the value is there.
  T* Peek() const { return value_.load(std::memory_order_acquire); }

  // `make` returns a `new T`.
  template <typename Make>
  T& Get(const Make& make) const {
    if (T* value = value_.load(std::memory_order_acquire)) return *value;
    T* made = make();
    T* expected = nullptr;
    if (value_.compare_exchange_strong(expected, made, std::memory_order_acq_rel)) return *made;
    delete made;
    return *expected;
  }

 private:
  mutable std::atomic<T*> value_{nullptr};
};

}  // namespace contact_toolkit
