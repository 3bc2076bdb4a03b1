// Bind `cdt/`: the triangulation of points and segments, and of polygons in space.
#include "cdt/cdt.hpp"

#include "bindings/statistics.hpp"
#include "cdt/polygons.hpp"

namespace bldsimp {
template <>
struct ItemTraits<Triangulator::SegmentPiece> {
  using Scalar = Index;
};

namespace {

void check_finite(std::span<const double> numbers) {
  double sum = 0.0;  // not a number as soon as any x * 0 is not 0
  for (const double number : numbers) sum += number * 0.0;
  if (sum != 0.0) throw nb::value_error("not finite");
}

void check_offsets(std::span<const std::int64_t> offsets, std::size_t count) {
  bool rising = offsets.empty() || (offsets.front() >= 0 && offsets.back() <= static_cast<std::int64_t>(count));
  for (std::size_t i = 1; i < offsets.size(); ++i) rising &= offsets[i - 1] <= offsets[i];
  if (!rising) throw nb::index_error("offsets out of range, or not rising");
}

// (crossing segments or None, points, triangles, neighbors, point of each input point, pieces, statistics); nothing
// after the points counts where segments cross.
auto triangulate(Input<Point2> points, Input<Triangulator::Segment> segments, bool carve, bool split_crossings,
                 std::optional<Input<double>> lift) {
  check_finite({points.data(), points.size()});
  check_range({segments.data(), segments.size()}, points.shape(0));
  if (lift && lift->shape(0) != points.shape(0)) throw nb::value_error("one lift per point");
  if (lift) check_finite(view<double>(*lift));
  // Small inputs share one workspace per thread; a large one gives its memory back.
  constexpr std::size_t small = 10000;
  static thread_local Triangulator shared;
  std::optional<Triangulator> own;
  if (points.shape(0) > small) own.emplace();
  Triangulator& triangulator = own ? *own : shared;
  nb::gil_scoped_release release;
  const Status status = triangulator.run(view<Point2>(points), view<Triangulator::Segment>(segments),
                                         {carve, split_crossings, lift ? lift->data() : nullptr});
  std::optional<std::tuple<Index, Index>> crossing;
  if (status == Status::crossing) crossing = {triangulator.crossing()[0], triangulator.crossing()[1]};
  auto [all, triangles, neighbors, point_of_input, pieces] = triangulator.release();
  return std::tuple(crossing, std::move(all), std::move(triangles), std::move(neighbors), std::move(point_of_input),
                    std::move(pieces), row_of(triangulator.statistics()));
}

}  // namespace

void bind_cdt(nb::module_& m) {
  m.def("triangulate", &triangulate, "points"_a, "segments"_a, "carve"_a, "split_crossings"_a, "lift"_a = nb::none());
  m.def("triangulate_polygons",
        unlocked([](std::span<const Point3> points, std::span<const std::int64_t> offsets, Indices corners) {
          check_range(corners, points.size());
          check_offsets(offsets, corners.size());
          auto [faces, polygon_of_face] = triangulate_polygons(points, offsets, corners);
          return std::tuple(std::move(faces), std::move(polygon_of_face));
        }),
        "points"_a, "offsets"_a, "corners"_a);
}

}  // namespace bldsimp
