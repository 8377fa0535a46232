#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <array>

#include "base/parallel.h"
#include "bindings/arrays.h"
#include "query/solid/solid.h"

namespace contact_toolkit {
namespace {

constexpr std::size_t kChunk = 256;  // points a thread takes at a time

nb::tuple SignedDistances(const Solid& solid, PointsIn points, int threads) {
  const auto* p = reinterpret_cast<const Vec3*>(points.data());
  const std::size_t count = points.shape(0);
  std::vector<double> distance(count);
  std::vector<Vec3> point(count), gradient(count);
  std::vector<std::int32_t> facet(count);
  {
    const nb::gil_scoped_release release;
    const auto chunks = static_cast<int>((count + kChunk - 1) / kChunk);
    ParallelFor(chunks, threads, [&](int chunk, int) {
      std::int32_t hint = -1;  // points in sequence are often close together
      const std::size_t end = std::min(count, (chunk + 1) * kChunk);
      for (std::size_t i = chunk * kChunk; i < end; ++i) {
        const SignedDistance found = solid.FindSignedDistance(p[i], hint);
        distance[i] = found.distance;
        point[i] = found.point;
        gradient[i] = found.gradient;
        facet[i] = solid.FacetGiven(found.facet);
        hint = found.slot;
      }
    });
  }
  return nb::make_tuple(ToNumpy(std::move(distance)), ToNumpy(std::move(point)),
                        ToNumpy(std::move(gradient)), ToNumpy(std::move(facet)));
}

Array<double> WindingNumbers(const CollisionMesh& mesh, PointsIn points) {
  std::vector<std::array<Vec3, 3>> facets;
  for (const auto& [a, b, c] : mesh.faces()) {
    facets.push_back({mesh.vertices()[a], mesh.vertices()[b], mesh.vertices()[c]});
  }
  const WindingTree tree(std::move(facets));
  const auto* p = reinterpret_cast<const Vec3*>(points.data());
  std::vector<double> numbers(points.shape(0));
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = tree.At(p[i]);
  return ToNumpy(std::move(numbers));
}

nb::dict Repairs(nb::handle self) {
  const SolidRepairs& repairs = nb::cast<const Solid&>(self).repairs();
  nb::dict lists;
  lists["turned_facets"] = ViewOf<std::int32_t>(repairs.turned, 0, self);
  lists["duplicate_facets"] = ViewOf<std::int32_t>(repairs.duplicates, 0, self);
  lists["collapsed_facets"] = ViewOf<std::int32_t>(repairs.collapsed, 0, self);
  lists["inner_facets"] = ViewOf<std::int32_t>(repairs.inner, 0, self);
  return lists;
}

}  // namespace

void BindPoint(nb::module_& m) {
  nb::enum_<SolidKind>(m, "SolidKind")
      .value("closed", SolidKind::kClosed)
      .value("nearly_closed", SolidKind::kNearlyClosed)
      .value("open", SolidKind::kOpen)
      .value("inside_out", SolidKind::kInsideOut);
  nb::class_<Solid>(m, "Solid")
      .def(
          "__init__",
          [](Solid* self, std::shared_ptr<CollisionMesh> mesh) {
            const nb::gil_scoped_release release;
            new (self) Solid(std::move(mesh));
          },
          nb::arg("mesh"))
      .def_prop_ro("kind", &Solid::kind)
      .def_prop_ro("has_inside", &Solid::has_inside)
      .def_prop_ro("openness", &Solid::openness)
      .def_prop_ro("repairs", &Repairs)
      .def_prop_ro("volume", &Solid::volume)
      .def_prop_ro("vertices",
                   [](nb::handle self) {
                     return ViewOf<double>(nb::cast<const Solid&>(self).mesh()->vertices(), 3,
                                           self);
                   })
      .def_prop_ro("faces", [](nb::handle self) {
        return ViewOf<std::int32_t>(nb::cast<const Solid&>(self).mesh()->faces(), 3, self);
      });
  m.def("winding_numbers", &WindingNumbers, nb::arg("mesh"), nb::arg("points").noconvert());
  m.def("signed_distance", &SignedDistances, nb::arg("solid"), nb::arg("points").noconvert(),
        nb::arg("threads"));
}

}  // namespace contact_toolkit
