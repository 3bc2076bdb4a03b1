// The only file that knows Python: casts arrays at the boundary and calls the kernels.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>

#include <cstring>
#include <optional>
#include <vector>

#include "cdt.hpp"
#include "polygons.hpp"
#include "predicates.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using bldsimp::Index;

template <class T, int Columns>
using Rows = nb::ndarray<const T, nb::shape<-1, Columns>, nb::c_contig, nb::device::cpu>;
template <class T>
using Row = nb::ndarray<const T, nb::shape<-1>, nb::c_contig, nb::device::cpu>;

// A new array of the given shape that owns a copy of the bytes.
template <class T>
nb::ndarray<nb::numpy, T> copied(const void* data, std::initializer_list<std::size_t> shape) {
  std::size_t count = 1;
  for (const std::size_t length : shape) count *= length;
  T* const memory = new T[count];
  nb::capsule owner(memory, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  if (count > 0) std::memcpy(memory, data, count * sizeof(T));
  return nb::ndarray<nb::numpy, T>(memory, shape, owner);
}

template <class T, class Element>
nb::ndarray<nb::numpy, T> copied_rows(const std::vector<Element>& rows) {
  constexpr std::size_t columns = sizeof(Element) / sizeof(T);
  if constexpr (columns == 1)
    return copied<T>(rows.data(), {rows.size()});
  else
    return copied<T>(rows.data(), {rows.size(), columns});
}

template <class Element, class Array>
std::span<const Element> viewed(const Array& array) {
  return {reinterpret_cast<const Element*>(array.data()), array.shape(0)};
}

// Signs of a predicate over rows of equal length.
template <class Element, class Array, class Predicate, class... Arrays>
nb::ndarray<nb::numpy, std::int8_t> signs(const Predicate& predicate, const Array& first, const Arrays&... rest) {
  const std::size_t count = first.shape(0);
  if (((rest.shape(0) != count) || ...)) throw nb::value_error("arrays of different lengths");
  std::vector<std::int8_t> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    const int value = predicate(viewed<Element>(first)[i], viewed<Element>(rest)[i]...);
    result[i] = static_cast<std::int8_t>((value > 0) - (value < 0));
  }
  return copied_rows<std::int8_t>(result);
}

// (crossing segments or None, points, triangles, neighbours, point of each input point, pieces,
// statistics); the rows after the first are empty where segments cross.
nb::tuple triangulate(Rows<double, 2> points, Rows<Index, 2> segments, bool carve, bool split_crossings,
                      std::optional<Row<double>> lift) {
  if (lift && lift->shape(0) != points.shape(0)) throw nb::value_error("as many lifts as points are needed");
  bldsimp::Triangulator triangulator;
  bldsimp::Status status;
  {
    nb::gil_scoped_release unlocked;
    status = triangulator.run(viewed<bldsimp::Point2>(points), viewed<bldsimp::Triangulator::Segment>(segments),
                              {carve, split_crossings, lift ? lift->data() : nullptr});
  }
  const auto& counts = triangulator.statistics();
  const nb::tuple statistics =
      nb::make_tuple(counts.by_poles, counts.by_determinant, counts.located, counts.walked, counts.flips);
  nb::object crossing = nb::none();
  if (status == bldsimp::Status::crossing)
    crossing = nb::make_tuple(triangulator.crossing()[0], triangulator.crossing()[1]);
  const auto all = triangulator.points();
  return nb::make_tuple(crossing, copied<double>(all.data(), {all.size(), 2}),
                        copied_rows<Index>(triangulator.triangles()), copied_rows<Index>(triangulator.neighbours()),
                        copied_rows<Index>(triangulator.point_of_input()), copied_rows<Index>(triangulator.pieces()),
                        statistics);
}

nb::tuple triangulate_polygons(Rows<double, 3> points, Row<std::int64_t> offsets, Row<Index> corners) {
  bldsimp::PolygonFaces result;
  {
    nb::gil_scoped_release unlocked;
    result = bldsimp::triangulate_polygons(viewed<bldsimp::Point3>(points), viewed<std::int64_t>(offsets),
                                           viewed<Index>(corners));
  }
  return nb::make_tuple(copied_rows<Index>(result.faces), copied_rows<Index>(result.polygon_of_face));
}

void bind_triangulation(nb::module_& m) {
  using P2 = Rows<double, 2>;
  using P3 = Rows<double, 3>;
  m.def("triangulate", &triangulate, "points"_a, "segments"_a, "carve"_a, "split_crossings"_a,
        "lift"_a = nb::none());
  m.def("triangulate_polygons", &triangulate_polygons, "points"_a, "offsets"_a, "corners"_a);
  m.def(
      "orient2d", [](P2 a, P2 b, P2 c) { return signs<bldsimp::Point2>(bldsimp::orient2d, a, b, c); }, "a"_a,
      "b"_a, "c"_a);
  m.def(
      "direction_by_poles",
      [](P2 a, P2 b, P2 c) { return signs<bldsimp::Point2>(bldsimp::direction_by_poles, a, b, c); }, "a"_a, "b"_a,
      "c"_a);
  m.def(
      "incircle", [](P2 a, P2 b, P2 c, P2 d) { return signs<bldsimp::Point2>(bldsimp::incircle, a, b, c, d); },
      "a"_a, "b"_a, "c"_a, "d"_a);
  m.def(
      "orient3d", [](P3 a, P3 b, P3 c, P3 d) { return signs<bldsimp::Point3>(bldsimp::orient3d, a, b, c, d); },
      "a"_a, "b"_a, "c"_a, "d"_a);
}

}  // namespace

NB_MODULE(_core, m) {
  m.doc() = "bldsimp's kernels";
  bind_triangulation(m);
}
