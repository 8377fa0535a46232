#include <nanobind/nanobind.h>

#include <algorithm>

#include "arrays.h"
#include "parallel.h"
#include "point_distance.h"

namespace contact_toolkit {
namespace {

constexpr std::size_t kChunk = 256;  // points a thread takes at a time

nb::tuple SignedDistances(const CollisionMesh& mesh, PointsIn points, int threads) {
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
        const SignedDistance found = FindSignedDistance(mesh, p[i], hint);
        distance[i] = found.distance;
        point[i] = found.point;
        gradient[i] = found.gradient;
        facet[i] = found.facet;
        hint = found.slot;
      }
    });
  }
  return nb::make_tuple(ToNumpy(std::move(distance)), ToNumpy(std::move(point)),
                        ToNumpy(std::move(gradient)), ToNumpy(std::move(facet)));
}

}  // namespace

void BindPoint(nb::module_& m) {
  m.def("signed_distance", &SignedDistances, nb::arg("mesh"), nb::arg("points").noconvert(),
        nb::arg("threads"));
}

}  // namespace contact_toolkit
