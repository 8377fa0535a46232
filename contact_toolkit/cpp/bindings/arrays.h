// How arrays cross between numpy and the core.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstring>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

#include "vec.h"

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

// A numpy array that owns the vector's storage; nothing is copied. E: the scalar type of an element
// (double for Vec3), `columns` how many of it an element holds (0: a one-dimensional array).
template <typename E, typename T>
nb::object ToNumpy(std::vector<T>&& values, std::size_t columns = 0) {
  auto* owner = new std::vector<T>(std::move(values));
  const nb::capsule capsule(owner, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  const std::size_t rows = owner->size();
  E* data = reinterpret_cast<E*>(owner->data());
  if (columns == 0) {
    return nb::cast(nb::ndarray<nb::numpy, E>(data, {rows}, capsule));
  }
  return nb::cast(nb::ndarray<nb::numpy, E>(data, {rows, columns}, capsule));
}
inline nb::object ToNumpy(std::vector<Vec3>&& values) {
  return ToNumpy<double>(std::move(values), 3);
}
inline nb::object ToNumpy(std::vector<double>&& values) {
  return ToNumpy<double>(std::move(values));
}
inline nb::object ToNumpy(std::vector<std::int32_t>&& values) {
  return ToNumpy<std::int32_t>(std::move(values));
}
inline nb::object ToNumpy(const Vec3& v) { return ToNumpy(std::vector<double>{v.x, v.y, v.z}); }

// A read-only numpy view of storage that `owner` keeps alive.
template <typename E, typename T>
nb::object ViewOf(const std::vector<T>& values, std::size_t columns, nb::handle owner) {
  const E* data = reinterpret_cast<const E*>(values.data());
  if (columns == 0) {
    return nb::cast(nb::ndarray<nb::numpy, nb::ro, E>(data, {values.size()}, owner));
  }
  return nb::cast(nb::ndarray<nb::numpy, nb::ro, E>(data, {values.size(), columns}, owner));
}

}  // namespace contact_toolkit
