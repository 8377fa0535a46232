// Immutable objects to bytes and back. What belongs to a type stands in one place for both ways:
//
//   auto Fields(Of<Type> auto& self) { return std::tie(self.a, self.b); }
//
// found where Type is declared, or beside it in its namespace.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace contact_toolkit {

template <class T, class Wanted>
concept Of = std::same_as<std::remove_const_t<T>, Wanted>;

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

// The first entries of a table, whose storage may hold more.
template <class Table, class Size>
struct InUse {
  Table& entries;
  Size& size;
};
template <class Table, class Size>
InUse(Table&, Size&) -> InUse<Table, Size>;

// The same bytes for the same values: numbers as they lie in memory, without padding.
class Packer {
 public:
  template <class... T>
  void operator()(const T&... values) {
    (Pack(values), ...);
  }

  const std::string& bytes() const { return bytes_; }

 private:
  template <class T>
  void Pack(const T& value) {
    if constexpr (Number<T>) {
      bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    } else {
      std::apply(*this, Fields(value));
    }
  }
  template <class T, class Allocator>
  void Pack(const std::vector<T, Allocator>& values) {
    Pack(std::uint64_t{values.size()});
    for (const T& value : values) Pack(value);
  }
  template <class T, std::size_t n>
  void Pack(const std::array<T, n>& values) {
    for (const T& value : values) Pack(value);
  }
  template <class T>
  void Pack(const std::shared_ptr<T>& pointer) {
    Pack(pointer != nullptr);
    if (pointer) Pack(*pointer);
  }
  template <class Table, class Size>
  void Pack(const InUse<Table, Size>& table) {
    Pack(std::uint64_t{table.size});
    for (std::size_t i = 0; i < table.size; ++i) Pack(table.entries[i]);
  }

  std::string bytes_;
};

// Throws std::invalid_argument where the bytes end too soon.
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : rest_(bytes) {}

  template <class... T>
  void operator()(T&&... values) {
    (Unpack(values), ...);
  }

  bool done() const { return rest_.empty(); }

 private:
  template <class T>
  void Unpack(T& value) {
    if constexpr (Number<T>) {
      Require(sizeof value);
      std::memcpy(&value, rest_.data(), sizeof value);
      rest_.remove_prefix(sizeof value);
    } else {
      std::apply(*this, Fields(value));
    }
  }
  template <class T, class Allocator>
  void Unpack(std::vector<T, Allocator>& values) {
    std::uint64_t size = 0;
    Unpack(size);
    Require(size);  // each takes a byte at least
    values.resize(size);
    for (T& value : values) Unpack(value);
  }
  template <class T, std::size_t n>
  void Unpack(std::array<T, n>& values) {
    for (T& value : values) Unpack(value);
  }
  template <class T>
  void Unpack(std::shared_ptr<T>& pointer) {
    bool held = false;
    Unpack(held);
    if (!held) return;
    const auto made = std::make_shared<std::remove_const_t<T>>();
    Unpack(*made);
    pointer = made;
  }
  template <class Table, class Size>
  void Unpack(InUse<Table, Size>& table) {
    Unpack(table.entries);
    table.size = table.entries.size();
  }

  void Require(std::uint64_t size) const {
    if (rest_.size() < size) throw std::invalid_argument("the bytes end too soon");
  }

  std::string_view rest_;
};

}  // namespace contact_toolkit
