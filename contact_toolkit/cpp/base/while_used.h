// Values by key, each shared by all who ask for it for as long as one of them holds it. What nobody
// holds any more goes when the next is made. Not thread-safe.
#pragma once

#include <map>
#include <memory>
#include <utility>

namespace contact_toolkit {

template <typename Key, typename T>
class WhileUsed {
 public:
  template <typename... Arguments>
  std::shared_ptr<const T> Get(const Key& key, Arguments&&... arguments) {
    if (const auto found = made_.find(key); found != made_.end()) {
      if (std::shared_ptr<const T> shared = found->second.lock()) return shared;
    }
    std::erase_if(made_, [](const auto& each) { return each.second.expired(); });
    auto made = std::make_shared<const T>(std::forward<Arguments>(arguments)...);
    made_[key] = made;
    return made;
  }

 private:
  std::map<Key, std::weak_ptr<const T>> made_;
};

}  // namespace contact_toolkit
