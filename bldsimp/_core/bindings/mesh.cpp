// Bind `mesh/`: weld, halfedges, orientation, crossings, distances, predicates.
#include "bindings/corner_rows.hpp"
#include "mesh/certificate.hpp"
#include "mesh/crossings.hpp"
#include "mesh/halfedges.hpp"
#include "mesh/orient.hpp"
#include "mesh/weld.hpp"

namespace bldsimp {
namespace {

void bind_topology(nb::module_& m) {
  nb::class_<WeldResult> welded(m, "WeldResult");
  def_views(welded, "points", &WeldResult::points, "point_of_row", &WeldResult::point_of_row, "faces",
            &WeldResult::faces, "source", &WeldResult::source, "class_of_row", &WeldResult::class_of_row);
  welded.def_ro("degenerate", &WeldResult::degenerate)
      .def_ro("duplicate", &WeldResult::duplicate)
      .def_ro("moved", &WeldResult::moved);
  m.def("weld", unlocked(&weld), "points"_a, "faces"_a, "distance"_a, "layer"_a.none() = nb::none());
  m.def("mark_used", unlocked(&mark_used), "faces"_a, "count"_a);

  nb::class_<RowArrays>(m, "CornerRows")
      .def(nb::init<Input<Face>, Input<Index>, Input<Index>, Input<Index>>(), "input"_a, "point_of_row"_a, "source"_a,
           "class_of_row"_a);

  nb::class_<Halfedges> halfedges(m, "Halfedges");
  def_views(halfedges, "twin", &Halfedges::twin, "group_start", &Halfedges::group_start, "group_members",
            &Halfedges::group_members);
  halfedges.def_ro("open_edges", &Halfedges::open_edges).def_ro("nonmanifold_edges", &Halfedges::nonmanifold_edges);
  m.def("pair_halfedges", unlocked(&pair_halfedges), "points"_a, "faces"_a, "rows"_a.none(), "width"_a);
  m.def("count_edges", unlocked_pair(&count_edges), "faces"_a, "point_count"_a);
  m.def("find_components", unlocked(&find_components), "faces"_a, "point_count"_a);
  m.def("find_misoriented", unlocked(&find_misoriented), "points"_a, "faces"_a, "halfedges"_a, "rows"_a, "fixed"_a);
}

void bind_distances(nb::module_& m) {
  nb::class_<SurfaceBound>(m, "SurfaceBound")
      .def_ro("distance", &SurfaceBound::distance)
      .def_ro("cells", &SurfaceBound::cells);
  nb::class_<FaceTree>(m, "FaceTree")
      .def(
          "__init__",
          [](FaceTree* self, Points points, Faces faces) {
            check_range(faces, points.size());
            nb::gil_scoped_release release;
            new (self) FaceTree(points, faces);
          },
          "points"_a, "faces"_a)
      .def("distances", unlocked(&FaceTree::distances), "queries"_a)
      .def("farthest", unlocked(&FaceTree::farthest), "queries"_a, "limit"_a)
      .def(
          "bound",
          [](const FaceTree& self, Points points, Faces faces, double precision, double known) {
            check_range(faces, points.size());
            nb::gil_scoped_release release;
            return bound_distance(points, faces, self, {known, precision});
          },
          "points"_a, "faces"_a, "precision"_a, "known"_a = 0.0)
      .def(
          "holds",
          [](const FaceTree& self, Points points, Faces faces, double limit) {
            check_range(faces, points.size());
            nb::gil_scoped_release release;
            return stays_within(points, faces, self, limit);
          },
          "points"_a, "faces"_a, "limit"_a);
  m.def("distances", unlocked([](Points queries, Points points, Faces faces) {
          check_range(faces, points.size());
          return FaceTree(points, faces).distances(queries);
        }),
        "queries"_a, "points"_a, "faces"_a);
}

// Binds a predicate over rows of arrays of equal lengths, which gives signs.
template <class Point, class... More>
void bind_predicate(nb::module_& m, const char* name, int (*predicate)(const Point&, const More&...),
                    const auto&... names) {
  const auto signs = [predicate](std::span<const Point> first, std::span<const More>... rest) {
    if (((rest.size() != first.size()) || ...)) throw nb::value_error("arrays of different lengths");
    std::vector<std::int8_t> result(first.size());
    for (std::size_t i = 0; i < first.size(); ++i)
      result[i] = static_cast<std::int8_t>(predicate(first[i], rest[i]...));
    return result;
  };
  m.def(name, signs, names...);
}

}  // namespace

void bind_mesh(nb::module_& m) {
  bind_topology(m);
  bind_distances(m);
  m.def(
      "find_crossings",
      [](Points points, Faces faces, std::optional<Input<std::uint8_t>> wanted) {
        check_range(faces, points.size());
        if (wanted && wanted->shape(0) != faces.size()) throw nb::value_error("one flag per face");
        nb::gil_scoped_release release;
        const std::vector<std::uint8_t> all(wanted ? 0 : faces.size(), 1);
        return find_crossings(points, faces, wanted ? view<std::uint8_t>(*wanted) : std::span(all));
      },
      "points"_a, "faces"_a, "wanted"_a = nb::none());
  bind_predicate(m, "orient2d", orient2d, "a"_a, "b"_a, "c"_a);
  bind_predicate(m, "direction_by_poles", direction_by_poles, "a"_a, "b"_a, "c"_a);
  bind_predicate(m, "incircle", incircle, "a"_a, "b"_a, "c"_a, "d"_a);
  bind_predicate(m, "orient3d", orient3d, "a"_a, "b"_a, "c"_a, "d"_a);
}

}  // namespace bldsimp
