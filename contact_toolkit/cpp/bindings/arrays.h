// How arrays cross between numpy and the core.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <array>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "math/vec.h"

namespace contact_toolkit {

namespace nb = nanobind;

// What the Python layer hands over: C-contiguous, of the right type, possibly read-only.
template <typename T, typename... Shape>
using ArrayIn = nb::ndarray<const T, nb::device::cpu, nb::c_contig, nb::shape<Shape::value...>>;
template <long long n>
struct Extent {
  static constexpr long long value = n;
};
using Any = Extent<-1>;
using PoseIn = ArrayIn<double, Extent<4>, Extent<4>>;
using PosesIn = ArrayIn<double, Any, Extent<4>, Extent<4>>;
using PointsIn = ArrayIn<double, Any, Extent<3>>;

static_assert(sizeof(Vec3) == 3 * sizeof(double));

// What numpy makes of an element: its scalar type, and how many columns (0: one-dimensional).
template <typename T>
struct Element {
  using Scalar = T;
  static constexpr std::size_t columns = 0;
};
template <>
struct Element<Vec3> {
  using Scalar = double;
  static constexpr std::size_t columns = 3;
};
template <typename T, std::size_t n>
struct Element<std::array<T, n>> {
  using Scalar = T;
  static constexpr std::size_t columns = n;
};

// A numpy array as Python sees it; named so that the generated stub tells its element type.
template <typename Scalar>
struct ScalarName;
template <>
struct ScalarName<double> {
  static constexpr auto value = nb::detail::const_name("numpy.typing.NDArray[numpy.float64]");
};
template <>
struct ScalarName<std::int32_t> {
  static constexpr auto value = nb::detail::const_name("numpy.typing.NDArray[numpy.int32]");
};
template <>
struct ScalarName<std::int64_t> {
  static constexpr auto value = nb::detail::const_name("numpy.typing.NDArray[numpy.int64]");
};
template <>
struct ScalarName<std::uint64_t> {
  static constexpr auto value = nb::detail::const_name("numpy.typing.NDArray[numpy.uint64]");
};
template <>
struct ScalarName<std::uint8_t> {
  static constexpr auto value = nb::detail::const_name("numpy.typing.NDArray[numpy.uint8]");
};
template <>
struct ScalarName<bool> {
  static constexpr auto value = nb::detail::const_name("numpy.typing.NDArray[numpy.bool]");
};
template <typename Scalar>
struct Array : nb::object {
  static constexpr auto Name = ScalarName<std::remove_const_t<Scalar>>::value;
  explicit Array(nb::object&& array) : nb::object(std::move(array)) {}
};

// A numpy array that owns the vector's storage; nothing is copied.
template <typename T, typename Allocator>
Array<typename Element<T>::Scalar> ToNumpy(std::vector<T, Allocator>&& values) {
  using Values = std::vector<T, Allocator>;
  using Scalar = typename Element<T>::Scalar;
  auto* owner = new Values(std::move(values));
  const nb::capsule capsule(owner, [](void* p) noexcept { delete static_cast<Values*>(p); });
  const std::size_t shape[2] = {owner->size(), Element<T>::columns};
  const std::size_t dimensions = Element<T>::columns == 0 ? 1 : 2;
  auto* data = reinterpret_cast<Scalar*>(owner->data());
  return Array<Scalar>(nb::cast(nb::ndarray<nb::numpy, Scalar>(data, dimensions, shape, capsule)));
}
inline Array<double> ToNumpy(const Vec3& v) { return ToNumpy(std::vector<double>{v.x, v.y, v.z}); }

// A read-only numpy view of storage that `owner` keeps alive.
template <typename E, typename T, typename Allocator>
Array<E> ViewOf(const std::vector<T, Allocator>& values, std::size_t columns, nb::handle owner) {
  const std::size_t shape[2] = {values.size(), columns};
  const E* data = reinterpret_cast<const E*>(values.data());
  return Array<E>(
      nb::cast(nb::ndarray<nb::numpy, nb::ro, E>(data, columns == 0 ? 1 : 2, shape, owner)));
}

// Column i of a table (see base/columns.h) as a read-only array that keeps the table alive.
template <class Table, std::size_t i>
auto ColumnOf(nb::handle table) {
  const auto& values = std::get<i>(Table::Columns(nb::cast<const Table&>(table)));
  using E = Element<typename std::remove_cvref_t<decltype(values)>::value_type>;
  return ViewOf<typename E::Scalar>(values, E::columns, table);
}

// Makes each column a property. Arrays are made when asked for, as making all of them takes longer
// than many a query.
template <class Table>
void BindColumns(nb::class_<Table>& bound) {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (bound.def_prop_ro(Table::kColumnNames[i], &ColumnOf<Table, i>), ...);
  }(std::make_index_sequence<Table::kColumnNames.size()>());
}

}  // namespace contact_toolkit
