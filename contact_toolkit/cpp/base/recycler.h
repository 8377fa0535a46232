// Objects that keep their storage when they are let go, so that making the next costs no
// allocation.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace contact_toolkit {

// Hands out shared objects; the last owner's release puts the object back, storage and all, after
// T::Retire() has let go of what it shares with others. All recyclers of a type share one stock:
// models that nobody frees, as Drake's binding leaves them, then hold no storage of their own.
template <typename T>
class Recycler {
 public:
  // An object in the state its last user left it in; reset what matters.
  std::shared_ptr<T> Take() {
    std::unique_ptr<T> object = stock_->Pop();
    if (!object) object = std::make_unique<T>();
    return std::shared_ptr<T>(
        object.release(), [stock = stock_](T* spent) { stock->Push(std::unique_ptr<T>(spent)); });
  }

 private:
  struct Stock {
    std::unique_ptr<T> Pop() {
      const std::lock_guard lock(mutex);
      if (idle.empty()) return nullptr;
      std::unique_ptr<T> object = std::move(idle.back());
      idle.pop_back();
      return object;
    }
    void Push(std::unique_ptr<T> object) {
      object->Retire();
      const std::lock_guard lock(mutex);
      if (idle.size() < kMaxIdle) idle.push_back(std::move(object));
    }

    static constexpr std::size_t kMaxIdle = 16;  // an integrator holds fewer at a time
    std::mutex mutex;
    std::vector<std::unique_ptr<T>> idle;
  };

  static const std::shared_ptr<Stock>& CommonStock() {
    static const std::shared_ptr<Stock> stock = std::make_shared<Stock>();
    return stock;
  }

  std::shared_ptr<Stock> stock_ = CommonStock();
};

}  // namespace contact_toolkit
