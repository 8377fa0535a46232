// Structures of arrays. Each names its columns in one place,
//
//   template <class Self> static auto Columns(Self& self) { return std::tie(self.a, self.b); }
//
// and what is done to all of them is done here.
#pragma once

#include <cstddef>
#include <tuple>
#include <utility>

namespace contact_toolkit {

template <class Table, class Function>
void ForEachColumn(Table& table, Function function) {
  std::apply([&](auto&... column) { (function(column), ...); }, Table::Columns(table));
}

template <class Table>
void ResizeColumns(Table* table, std::size_t rows) {
  ForEachColumn(*table, [&](auto& column) { column.resize(rows); });
}

template <class Table>
void ReserveColumns(Table* table, std::size_t rows) {
  ForEachColumn(*table, [&](auto& column) { column.reserve(rows); });
}

// Calls function(column of a, same column of b) for each.
template <class A, class B, class Function>
void ForEachColumnOfBoth(A& a, B& b, Function function) {
  const auto of_a = std::remove_const_t<A>::Columns(a);
  const auto of_b = std::remove_const_t<B>::Columns(b);
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (function(std::get<i>(of_a), std::get<i>(of_b)), ...);
  }(std::make_index_sequence<std::tuple_size_v<decltype(of_a)>>());
}

// Appends all rows of a table.
template <class Table>
void AppendColumns(const Table& from, Table* to) {
  ForEachColumnOfBoth(from, *to, [](const auto& source, auto& target) {
    target.insert(target.end(), source.begin(), source.end());
  });
}

// Appends row i of a table.
template <class Table>
void AppendRow(const Table& from, std::size_t i, Table* to) {
  ForEachColumnOfBoth(from, *to,
                      [&](const auto& source, auto& target) { target.push_back(source[i]); });
}

// Where the columns of a table begin, known to stay while rows are written.
template <class Table>
class RowTarget {
 public:
  explicit RowTarget(Table* table)
      : begins_(std::apply([](auto&... column) { return std::tuple(column.data()...); },
                           Table::Columns(*table))) {}

  // One value for each column, in their order.
  template <class... Values>
  void Write(std::size_t row, const Values&... values) const {
    static_assert(sizeof...(Values) == std::tuple_size_v<decltype(begins_)>);
    std::apply([&](auto*... begin) { ((begin[row] = values), ...); }, begins_);
  }

 private:
  using Begins = decltype(std::apply([](auto&... column) { return std::tuple(column.data()...); },
                                     Table::Columns(std::declval<Table&>())));
  Begins begins_;
};

}  // namespace contact_toolkit
