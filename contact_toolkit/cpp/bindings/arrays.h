// How arrays cross between numpy and the core.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <array>
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

// A numpy array that owns the vector's storage; nothing is copied.
template <typename T, typename Allocator>
nb::object ToNumpy(std::vector<T, Allocator>&& values) {
  using Values = std::vector<T, Allocator>;
  using Scalar = typename Element<T>::Scalar;
  auto* owner = new Values(std::move(values));
  const nb::capsule capsule(owner, [](void* p) noexcept { delete static_cast<Values*>(p); });
  const std::size_t rows = owner->size();
  auto* data = reinterpret_cast<Scalar*>(owner->data());
  if constexpr (Element<T>::columns == 0) {
    return nb::cast(nb::ndarray<nb::numpy, Scalar>(data, {rows}, capsule));
  } else {
    return nb::cast(nb::ndarray<nb::numpy, Scalar>(data, {rows, Element<T>::columns}, capsule));
  }
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
