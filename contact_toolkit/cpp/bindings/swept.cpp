#include "query/swept/swept.h"

#include <nanobind/nanobind.h>

#include "base/parallel.h"
#include "bindings/arrays.h"
#include "bindings/shapes.h"

namespace contact_toolkit {
namespace {

using BoundsIn = ArrayIn<double, Any>;

Motion MotionOf(const PosesIn& start, const PosesIn& end, int i) {
  return {Pose::FromMatrix(start.data() + 16 * i), Pose::FromMatrix(end.data() + 16 * i)};
}

void RequireRows(std::size_t rows, const PosesIn& start) {
  if (rows != start.shape(0)) throw nb::value_error("all arguments need the same number of rows");
}

// The answers to all motions, each an element of `answers`.
template <typename Answer, typename Find>
std::vector<Answer> FindAll(const PosesIn& start, const PosesIn& end, int threads, Find&& find) {
  RequireRows(end.shape(0), start);
  std::vector<Answer> answers(start.shape(0));
  const nb::gil_scoped_release release;
  ParallelFor(static_cast<int>(answers.size()), threads,
              [&](int i, int) { answers[i] = find(MotionOf(start, end, i), i); });
  return answers;
}

template <typename Answer, typename Field>
auto Column(const std::vector<Answer>& answers, Field Answer::* field) {
  std::vector<Field> column;
  column.reserve(answers.size());
  for (const Answer& answer : answers) column.push_back(answer.*field);
  return column;
}

Array<bool> ToBooleans(std::vector<std::uint8_t>&& values) {
  return Array<bool>(ToNumpy(std::move(values)).attr("view")("bool"));
}

// The answers at all poses, each an element of `answers`.
template <typename Answer, typename Find>
std::vector<Answer> FindAll(const PosesIn& poses, int threads, Find&& find) {
  return FindAll<Answer>(poses, poses, threads, std::forward<Find>(find));
}

nb::dict DistancesOf(nb::handle A, nb::handle B, PosesIn poses, BoundsIn upper_bound, int threads) {
  RequireRows(upper_bound.shape(0), poses);
  const ConvexLeaves a = LeavesOf(A), b = LeavesOf(B);
  using Answer = SweptDistance;
  const auto answers = FindAll<Answer>(poses, threads, [&](const Motion& still, int i) {
    return FindSweptDistance(a, b, still, 0, upper_bound.data()[i]);
  });
  nb::dict columns;
  columns["distance"] = ToNumpy(Column(answers, &Answer::distance));
  columns["p_ACa"] = ToNumpy(Column(answers, &Answer::p_ACa));
  columns["p_ACb"] = ToNumpy(Column(answers, &Answer::p_ACb));
  columns["facet_a"] = ToNumpy(Column(answers, &Answer::facet_a));
  columns["facet_b"] = ToNumpy(Column(answers, &Answer::facet_b));
  return columns;
}

Array<bool> IntersectionsOf(nb::handle A, nb::handle B, PosesIn poses, int threads) {
  const ConvexLeaves a = LeavesOf(A), b = LeavesOf(B);
  return ToBooleans(FindAll<std::uint8_t>(poses, threads, [&](const Motion& still, int) {
    return static_cast<std::uint8_t>(SweptIntersects(a, b, still, 0));
  }));
}

double ErrorOf(const SweptDistance& answer) {
  return answer.facet_a < 0 ? 0 : answer.distance - answer.lower_bound;
}

nb::dict SweptDistancesOf(nb::handle A, nb::handle B, PosesIn start, PosesIn end, double tolerance,
                          BoundsIn upper_bound, int threads) {
  RequireRows(upper_bound.shape(0), start);
  const ConvexLeaves a = LeavesOf(A), b = LeavesOf(B);
  using Answer = SweptDistance;
  const auto answers = FindAll<Answer>(start, end, threads, [&](const Motion& motion, int i) {
    return FindSweptDistance(a, b, motion, tolerance, upper_bound.data()[i]);
  });
  std::vector<double> error;
  std::vector<std::uint8_t> converged;
  for (const Answer& answer : answers) {
    error.push_back(ErrorOf(answer));
    converged.push_back(answer.converged);
  }
  nb::dict columns;
  columns["distance"] = ToNumpy(Column(answers, &Answer::lower_bound));
  columns["error"] = ToNumpy(std::move(error));
  columns["time"] = ToNumpy(Column(answers, &Answer::time));
  columns["p_ACa"] = ToNumpy(Column(answers, &Answer::p_ACa));
  columns["p_ACb"] = ToNumpy(Column(answers, &Answer::p_ACb));
  columns["facet_a"] = ToNumpy(Column(answers, &Answer::facet_a));
  columns["facet_b"] = ToNumpy(Column(answers, &Answer::facet_b));
  columns["converged"] = ToBooleans(std::move(converged));
  return columns;
}

nb::dict TimesOfImpactOf(nb::handle A, nb::handle B, PosesIn start, PosesIn end, double separation,
                         double tolerance, int threads) {
  const ConvexLeaves a = LeavesOf(A), b = LeavesOf(B);
  using Answer = TimeOfImpact;
  const auto answers = FindAll<Answer>(start, end, threads, [&](const Motion& motion, int) {
    return FindTimeOfImpact(a, b, motion, separation, tolerance);
  });
  nb::dict columns;
  columns["time"] = ToNumpy(Column(answers, &Answer::time));
  columns["distance"] = ToNumpy(Column(answers, &Answer::distance));
  columns["p_ACa"] = ToNumpy(Column(answers, &Answer::p_ACa));
  columns["p_ACb"] = ToNumpy(Column(answers, &Answer::p_ACb));
  columns["normal_A"] = ToNumpy(Column(answers, &Answer::normal_A));
  columns["facet_a"] = ToNumpy(Column(answers, &Answer::facet_a));
  columns["facet_b"] = ToNumpy(Column(answers, &Answer::facet_b));
  std::vector<std::int32_t> status;
  for (const Answer& answer : answers) status.push_back(static_cast<int>(answer.status));
  columns["status"] = ToNumpy(std::move(status));
  return columns;
}

Array<bool> SweptIntersectionsOf(nb::handle A, nb::handle B, PosesIn start, PosesIn end,
                                 double tolerance, int threads) {
  const ConvexLeaves a = LeavesOf(A), b = LeavesOf(B);
  return ToBooleans(FindAll<std::uint8_t>(start, end, threads, [&](const Motion& motion, int) {
    return static_cast<std::uint8_t>(SweptIntersects(a, b, motion, tolerance));
  }));
}

SweptDistance SweptDistanceOf(nb::handle A, nb::handle B, PoseIn start, PoseIn end,
                              double tolerance, double upper_bound) {
  const ConvexLeaves a = LeavesOf(A), b = LeavesOf(B);
  const Motion motion(Pose::FromMatrix(start.data()), Pose::FromMatrix(end.data()));
  const nb::gil_scoped_release release;
  return FindSweptDistance(a, b, motion, tolerance, upper_bound);
}

nb::dict TimeOfImpactOf(nb::handle A, nb::handle B, PoseIn start, PoseIn end, double separation,
                        double tolerance) {
  const ConvexLeaves a = LeavesOf(A), b = LeavesOf(B);
  const Motion motion(Pose::FromMatrix(start.data()), Pose::FromMatrix(end.data()));
  TimeOfImpact answer;
  {
    const nb::gil_scoped_release release;
    answer = FindTimeOfImpact(a, b, motion, separation, tolerance);
  }
  nb::dict fields;
  fields["time"] = answer.time;
  fields["distance"] = answer.distance;
  fields["p_ACa"] = ToNumpy(answer.p_ACa);
  fields["p_ACb"] = ToNumpy(answer.p_ACb);
  fields["normal_A"] = ToNumpy(answer.normal_A);
  fields["facet_a"] = answer.facet_a;
  fields["facet_b"] = answer.facet_b;
  fields["status"] = static_cast<int>(answer.status);
  return fields;
}

bool SweptIntersectsOf(nb::handle A, nb::handle B, PoseIn start, PoseIn end, double tolerance) {
  const ConvexLeaves a = LeavesOf(A), b = LeavesOf(B);
  const Motion motion(Pose::FromMatrix(start.data()), Pose::FromMatrix(end.data()));
  const nb::gil_scoped_release release;
  return SweptIntersects(a, b, motion, tolerance);
}

}  // namespace

void BindSwept(nb::module_& m) {
  const auto A = nb::arg("A"), B = nb::arg("B"), tolerance = nb::arg("tolerance"),
             separation = nb::arg("separation"), bound = nb::arg("upper_bound"),
             threads = nb::arg("threads");
  const auto pose = nb::arg("X_AB").noconvert(), start = nb::arg("X_AB_start").noconvert(),
             end = nb::arg("X_AB_end").noconvert(), bounds = nb::arg("upper_bound").noconvert();
  m.def("distances", &DistancesOf, A, B, pose, bounds, threads);
  m.def("intersections", &IntersectionsOf, A, B, pose, threads);
  // Arrays are made when asked for: making all takes longer than many a query.
  nb::class_<SweptDistance>(m, "SweptDistance")
      .def_ro("distance", &SweptDistance::lower_bound)
      .def_prop_ro("error", &ErrorOf)
      .def_ro("time", &SweptDistance::time)
      .def_prop_ro("p_ACa", [](const SweptDistance& found) { return ToNumpy(found.p_ACa); })
      .def_prop_ro("p_ACb", [](const SweptDistance& found) { return ToNumpy(found.p_ACb); })
      .def_ro("facet_a", &SweptDistance::facet_a)
      .def_ro("facet_b", &SweptDistance::facet_b)
      .def_ro("converged", &SweptDistance::converged);
  m.def("swept_distance", &SweptDistanceOf, A, B, start, end, tolerance, bound);
  m.def("swept_distances", &SweptDistancesOf, A, B, start, end, tolerance, bounds, threads);
  m.def("swept_intersects", &SweptIntersectsOf, A, B, start, end, tolerance);
  m.def("swept_intersections", &SweptIntersectionsOf, A, B, start, end, tolerance, threads);
  m.def("time_of_impact", &TimeOfImpactOf, A, B, start, end, separation, tolerance);
  m.def("times_of_impact", &TimesOfImpactOf, A, B, start, end, separation, tolerance, threads);
}

}  // namespace contact_toolkit
