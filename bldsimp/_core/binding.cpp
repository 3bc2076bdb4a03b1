// The only file that knows Python: casts arrays at the boundary and calls the kernels.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <optional>
#include <tuple>

#include "bodies.hpp"
#include "cdt.hpp"
#include "charts.hpp"
#include "collapse.hpp"
#include "conform.hpp"
#include "crossings.hpp"
#include "distances.hpp"
#include "facets.hpp"
#include "halfedges.hpp"
#include "lids.hpp"
#include "orient.hpp"
#include "outlines.hpp"
#include "parallel.hpp"
#include "polygons.hpp"
#include "predicates.hpp"
#include "retriangulate.hpp"
#include "rows.hpp"
#include "spare.hpp"
#include "thin.hpp"
#include "weld.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace bldsimp {
namespace {

template <class T, class Shape>
using In = nb::ndarray<const T, Shape, nb::c_contig, nb::device::cpu>;
using Points3 = In<double, nb::shape<-1, 3>>;
using Faces3 = In<Index, nb::shape<-1, 3>>;
using Pairs = In<Index, nb::shape<-1, 2>>;
using Points2 = In<double, nb::shape<-1, 2>>;
using Indices = In<Index, nb::shape<-1>>;
using Doubles = In<double, nb::shape<-1>>;
using Bytes = In<std::uint8_t, nb::shape<-1>>;

// Rows of a C-contiguous array seen as the structs that the kernels use.
template <class Struct, class Array>
std::span<const Struct> rows(const Array& array) {
  return {reinterpret_cast<const Struct*>(array.data()), array.shape(0)};
}
template <class T>
std::span<const T> flat(const In<T, nb::shape<-1>>& array) {
  return {array.data(), array.shape(0)};
}

// Hands a vector over to NumPy without a copy; `Scalar` is what its items are made of.
template <class Scalar, class Item, class Allocator>
auto give(std::vector<Item, Allocator>&& items) {
  using Items = std::vector<Item, Allocator>;
  auto* owned = new Items(std::move(items));
  nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<Items*>(p); });
  constexpr std::size_t width = sizeof(Item) / sizeof(Scalar);
  auto* data = reinterpret_cast<Scalar*>(owned->data());
  if constexpr (width == 1)
    return nb::ndarray<nb::numpy, Scalar>(data, {owned->size()}, owner);
  else
    return nb::ndarray<nb::numpy, Scalar>(data, {owned->size(), width}, owner);
}

// A read-only view of a vector inside a kernel's result, which it keeps alive.
template <class Scalar, class Item, class Allocator>
auto view(nb::handle owner, const std::vector<Item, Allocator>& items) {
  constexpr std::size_t width = sizeof(Item) / sizeof(Scalar);
  auto* data = reinterpret_cast<const Scalar*>(items.data());
  if constexpr (width == 1)
    return nb::ndarray<nb::numpy, const Scalar>(data, {items.size()}, owner);
  else
    return nb::ndarray<nb::numpy, const Scalar>(data, {items.size(), width}, owner);
}

template <class Scalar, class Result, class Items, class Class>
void def_view(Class& c, const char* name, Items Result::*member) {
  c.def_prop_ro(name, [member](nb::handle self) {
    return view<Scalar>(self, nb::cast<const Result&>(self).*member);
  });
}

auto row_of(const Statistics& counts) {
  return std::tuple(counts.by_poles, counts.by_determinant, counts.located, counts.walked, counts.flips);
}

// Arrays of which `Rows` looks at the data.
struct RowArrays {
  Faces3 input;
  Indices point_of_row, source, class_of_row;
};
Rows seen(const RowArrays* arrays) {
  if (!arrays) return {};
  return {rows<Face>(arrays->input), flat(arrays->point_of_row), flat(arrays->source), flat(arrays->class_of_row)};
}

void bind_mesh(nb::module_& m) {
  nb::class_<Welded> welded(m, "Welded");
  def_view<double>(welded, "points", &Welded::points);
  def_view<Index>(welded, "point_of_row", &Welded::point_of_row);
  def_view<Index>(welded, "faces", &Welded::faces);
  def_view<Index>(welded, "source", &Welded::source);
  def_view<Index>(welded, "class_of_row", &Welded::class_of_row);
  welded.def_ro("degenerate", &Welded::degenerate)
      .def_ro("duplicate", &Welded::duplicate)
      .def_ro("moved", &Welded::moved);
  m.def(
      "weld",
      [](Points3 points, Faces3 faces, double distance, std::optional<Indices> layer) {
        nb::gil_scoped_release release;
        return weld(rows<Vec3>(points), rows<Face>(faces), distance, layer ? flat(*layer) : std::span<const Index>{});
      },
      "points"_a, "faces"_a, "distance"_a, "layer"_a = nb::none());

  m.def(
      "mark_used", [](Faces3 faces, std::size_t count) { return give<std::uint8_t>(mark_used(rows<Face>(faces), count)); },
      "faces"_a, "count"_a);

  nb::class_<RowArrays>(m, "Rows")
      .def(
          "__init__",
          [](RowArrays* self, Faces3 input, Indices point_of_row, Indices source, Indices class_of_row) {
            new (self) RowArrays{std::move(input), std::move(point_of_row), std::move(source), std::move(class_of_row)};
          },
          "input"_a, "point_of_row"_a, "source"_a, "class_of_row"_a);

  nb::class_<Halfedges> halfedges(m, "Halfedges");
  def_view<Index>(halfedges, "twin", &Halfedges::twin);
  def_view<Index>(halfedges, "group_start", &Halfedges::group_start);
  def_view<Index>(halfedges, "group_members", &Halfedges::group_members);
  halfedges.def_ro("open_edges", &Halfedges::open_edges)
      .def_ro("nonmanifold_edges", &Halfedges::nonmanifold_edges);
  m.def(
      "count_edges",
      [](Faces3 faces, Index point_count) {
        nb::gil_scoped_release release;
        const auto [open, nonmanifold] = count_edges(rows<Face>(faces), point_count);
        return std::tuple(open, nonmanifold);
      },
      "faces"_a, "point_count"_a);
  m.def(
      "find_components",
      [](Faces3 faces, Index point_count) {
        Array<Index> component;
        {
          nb::gil_scoped_release release;
          component = find_components(rows<Face>(faces), point_count);
        }
        return give<Index>(std::move(component));
      },
      "faces"_a, "point_count"_a);
  m.def(
      "find_bodies",
      [](Points3 points, Faces3 faces) {
        Array<Index> body;
        {
          nb::gil_scoped_release release;
          body = find_bodies(rows<Vec3>(points), rows<Face>(faces));
        }
        return give<Index>(std::move(body));
      },
      "points"_a, "faces"_a);
  m.def(
      "find_spare",
      [](Points3 points, Faces3 faces, Indices body, Bytes pinned, double limit) {
        std::vector<std::uint8_t> spare;
        {
          nb::gil_scoped_release release;
          spare = find_spare(rows<Vec3>(points), rows<Face>(faces), flat(body), flat(pinned), limit);
        }
        return give<std::uint8_t>(std::move(spare));
      },
      "points"_a, "faces"_a, "body"_a, "pinned"_a, "limit"_a);
  m.def(
      "pair_halfedges",
      [](Points3 points, Faces3 faces, const RowArrays* face_rows, double width) {
        nb::gil_scoped_release release;
        return pair_halfedges(rows<Vec3>(points), rows<Face>(faces), seen(face_rows), width);
      },
      "points"_a, "faces"_a, "rows"_a.none(), "width"_a);

  m.def(
      "find_turned",
      [](Points3 points, Faces3 faces, const Halfedges& h, const RowArrays& face_rows, Bytes fixed) {
        std::vector<Index> turned;
        {
          nb::gil_scoped_release release;
          turned = find_turned(rows<Vec3>(points), rows<Face>(faces), h, seen(&face_rows), flat(fixed));
        }
        return give<Index>(std::move(turned));
      },
      "points"_a, "faces"_a, "halfedges"_a, "rows"_a, "fixed"_a);

  nb::class_<Facets> facets(m, "Facets");
  def_view<Index>(facets, "facet_of_face", &Facets::facet_of_face);
  def_view<double>(facets, "planes", &Facets::planes);
  def_view<std::uint8_t>(facets, "curved", &Facets::curved);
  facets.def(
      "__init__",
      [](Facets* self, Indices facet_of_face, In<double, nb::shape<-1, 5>> planes) {
        const auto all = rows<Plane>(planes);
        new (self) Facets{{facet_of_face.data(), facet_of_face.data() + facet_of_face.shape(0)}, {all.begin(), all.end()}, {}};
      },
      "facet_of_face"_a, "planes"_a);
  m.def(
      "find_facets",
      [](Points3 points, Faces3 faces, const Halfedges& h, Indices label, std::tuple<double, double, double> origin,
         double width, double needle, double fold) {
        nb::gil_scoped_release release;
        const auto [x, y, z] = origin;
        return find_facets(rows<Vec3>(points), rows<Face>(faces), h.twin, flat(label), {x, y, z}, {width, needle, fold});
      },
      "points"_a, "faces"_a, "halfedges"_a, "label"_a, "origin"_a, "width"_a, "needle"_a, "fold"_a);

  m.def(
      "group_faces",
      [](const Facets& all) {
        Grouped grouped = group_faces(all);
        return std::tuple(give<Index>(std::move(grouped.start)), give<Index>(std::move(grouped.order)));
      },
      "facets"_a);
  m.def("split_off", [](const Facets& all, Indices cut) { return split_off(all, flat(cut)); }, "facets"_a, "cut"_a);

  nb::class_<Charts> charts(m, "Charts");
  def_view<Index>(charts, "chart_of_face", &Charts::chart_of_face);
  def_view<double>(charts, "maps", &Charts::maps);
  def_view<double>(charts, "spans", &Charts::spans);
  m.def(
      "find_charts",
      [](Points3 points, Faces3 faces, const Halfedges& h, Indices start, Indices order, const RowArrays& face_rows,
         Indices part_of_face, In<double, nb::shape<-1, -1>> values, In<double, nb::shape<-1, -1>> steps,
         Doubles limits) {
        if (values.shape(1) != limits.shape(0) || steps.shape(1) != limits.shape(0))
          throw nb::value_error("one limit, and one number of steps, for each column");
        nb::gil_scoped_release release;
        const Carried carried{{values.data(), values.size()}, {steps.data(), steps.size()}, flat(limits)};
        return find_charts(rows<Vec3>(points), rows<Face>(faces), h.twin, flat(start), flat(order), seen(&face_rows),
                           flat(part_of_face), carried);
      },
      "points"_a, "faces"_a, "halfedges"_a, "start"_a, "order"_a, "rows"_a, "part_of_face"_a, "values"_a, "steps"_a,
      "limits"_a);
  m.def(
      "find_smooth",
      [](Points3 points, Faces3 faces, const Halfedges& h, const RowArrays& face_rows, Points3 normals, double cosine,
         double needle) {
        Array<Index> set;
        {
          nb::gil_scoped_release release;
          set = find_smooth(rows<Vec3>(points), rows<Face>(faces), h.twin, seen(&face_rows), rows<Vec3>(normals),
                            cosine, needle);
        }
        return give<Index>(std::move(set));
      },
      "points"_a, "faces"_a, "halfedges"_a, "rows"_a, "normals"_a, "cosine"_a, "needle"_a);

  nb::class_<Outlines> outlines(m, "Outlines");
  def_view<Index>(outlines, "chain_start", &Outlines::chain_start);
  def_view<Index>(outlines, "chain_points", &Outlines::chain_points);
  def_view<Index>(outlines, "use_start", &Outlines::use_start);
  def_view<std::uint8_t>(outlines, "is_corner", &Outlines::is_corner);
  def_view<Index>(outlines, "inner", &Outlines::inner);
  def_view<Index>(outlines, "back", &Outlines::back);
  outlines.def_ro("touching", &Outlines::touching);
  outlines.def_prop_ro("use_facet", [](const Outlines& o) {
    std::vector<Index> facet;
    for (const Use& use : o.uses) facet.push_back(use.facet);
    return give<Index>(std::move(facet));
  }, nb::rv_policy::automatic);
  outlines.def_prop_ro("use_forward", [](const Outlines& o) {
    std::vector<std::uint8_t> forward;
    for (const Use& use : o.uses) forward.push_back(use.forward);
    return give<std::uint8_t>(std::move(forward));
  }, nb::rv_policy::automatic);
  m.def(
      "trace_outlines",
      [](Faces3 faces, Index point_count, const Halfedges& h, const Facets& f, Bytes frozen) {
        nb::gil_scoped_release release;
        return trace_outlines(rows<Face>(faces), point_count, h, f.facet_of_face, flat(frozen));
      },
      "faces"_a, "point_count"_a, "halfedges"_a, "facets"_a, "frozen"_a);

  m.def(
      "thin_chains",
      [](Points3 points, const Outlines& o, Doubles limit, Bytes keep) {
        std::vector<std::uint8_t> kept(keep.data(), keep.data() + keep.shape(0));
        {
          nb::gil_scoped_release release;
          thin_chains(rows<Vec3>(points), o, flat(limit), kept);
        }
        return give<std::uint8_t>(std::move(kept));
      },
      "points"_a, "outlines"_a, "limit"_a, "keep"_a);

  nb::class_<std::vector<Piece>> pieces(m, "Pieces");
  const auto piece_column = [&](const char* name, Index Piece::*member) {
    pieces.def_prop_ro(name, [member](const std::vector<Piece>& all) {
      std::vector<Index> column;
      for (const Piece& piece : all) column.push_back(piece.*member);
      return give<Index>(std::move(column));
    }, nb::rv_policy::automatic);
  };
  piece_column("begin", &Piece::from);
  piece_column("end", &Piece::to);
  piece_column("chain", &Piece::chain);
  piece_column("farthest", &Piece::farthest);
  pieces.def_prop_ro("deviation", [](const std::vector<Piece>& all) {
    std::vector<double> column;
    for (const Piece& piece : all) column.push_back(piece.deviation);
    return give<double>(std::move(column));
  }, nb::rv_policy::automatic);
  m.def(
      "lay_pieces",
      [](Points3 points, const Outlines& o, Bytes kept) {
        nb::gil_scoped_release release;
        return lay_pieces(rows<Vec3>(points), o, flat(kept));
      },
      "points"_a, "outlines"_a, "kept"_a);

  nb::class_<PieceEdges> edges(m, "PieceEdges");
  def_view<Index>(edges, "edges", &PieceEdges::edges);
  def_view<Index>(edges, "clashing", &PieceEdges::clashing);
  def_view<Index>(edges, "healed_pieces", &PieceEdges::healed_pieces);
  edges.def_ro("healed", &PieceEdges::healed);
  m.def(
      "merge_pieces",
      [](const std::vector<Piece>& all, const Outlines& o) {
        nb::gil_scoped_release release;
        return merge_pieces(all, o);
      },
      "pieces"_a, "outlines"_a);

  nb::class_<Patches> patches(m, "Patches");
  def_view<Index>(patches, "triangles", &Patches::triangles);
  def_view<Index>(patches, "facet_of_triangle", &Patches::facet_of_triangle);
  def_view<std::uint8_t>(patches, "outcomes", &Patches::outcomes);
  def_view<double>(patches, "reach", &Patches::reach);
  def_view<Index>(patches, "put_back", &Patches::put_back);
  def_view<Index>(patches, "trouble", &Patches::trouble);
  patches.def_prop_ro("statistics", [](const Patches& p) { return row_of(p.statistics); });
  m.def(
      "retriangulate",
      [](Points3 points, Faces3 faces, Indices face_start, Indices face_order, const Facets& f, const Outlines& o,
         const std::vector<Piece>& all, Bytes kept, Doubles reach, Indices wanted, Bytes keep) {
        nb::gil_scoped_release release;
        const FacetParts parts{rows<Vec3>(points), rows<Face>(faces), flat(face_start), flat(face_order),
                               f.planes, o, all, flat(kept), flat(reach)};
        return retriangulate(parts, flat(wanted), flat(keep));
      },
      "points"_a, "faces"_a, "face_start"_a, "face_order"_a, "facets"_a, "outlines"_a, "pieces"_a, "kept"_a,
      "reach"_a, "wanted"_a, "keep"_a);

  nb::class_<Conformed> conformed(m, "Conformed");
  def_view<double>(conformed, "made", &Conformed::made);
  def_view<Index>(conformed, "triangles", &Conformed::triangles);
  def_view<Index>(conformed, "facet_of_triangle", &Conformed::facet_of_triangle);
  def_view<std::uint8_t>(conformed, "facets", &Conformed::facets);
  conformed.def_prop_ro("statistics", [](const Conformed& c) { return row_of(c.statistics); });
  m.def(
      "conform",
      [](Points3 points, In<double, nb::shape<-1, 5>> planes, const Outlines& o, const std::vector<Piece>& all,
         Faces3 triangles, Indices facet_of_triangle, Bytes keep) {
        nb::gil_scoped_release release;
        return conform({rows<Vec3>(points), rows<Plane>(planes), o, all, rows<Face>(triangles),
                        flat(facet_of_triangle), flat(keep)});
      },
      "points"_a, "planes"_a, "outlines"_a, "pieces"_a, "triangles"_a, "facet_of_triangle"_a, "keep"_a);

  m.def(
      "find_misfits",
      [](Faces3 triangles, Indices facet_of_triangle, const PieceEdges& expected, Bytes keep, const Outlines& o) {
        std::vector<Misfit> misfits;
        {
          nb::gil_scoped_release release;
          misfits = find_misfits(rows<Face>(triangles), flat(facet_of_triangle), expected, flat(keep), o.back);
        }
        return give<Index>(std::move(misfits));
      },
      "triangles"_a, "facet_of_triangle"_a, "expected"_a, "keep"_a, "outlines"_a);
  nb::class_<Lids> closing(m, "Lids");
  def_view<Index>(closing, "faces", &Lids::faces);
  def_view<Index>(closing, "beside", &Lids::beside);
  closing.def_ro("closed", &Lids::closed);
  m.def(
      "find_lids",
      [](Points3 points, Faces3 faces, Indices label, Bytes pinned, double limit) {
        nb::gil_scoped_release release;
        return find_lids(rows<Vec3>(points), rows<Face>(faces), flat(label), flat(pinned), limit);
      },
      "points"_a, "faces"_a, "label"_a, "pinned"_a, "limit"_a);
  nb::class_<Progress>(m, "Progress").def(nb::init<>()).def_prop_ro("gone", [](const Progress& p) { return p.gone.load(); });
  nb::class_<Collapsed> collapsed(m, "Collapsed");
  def_view<double>(collapsed, "points", &Collapsed::points);
  def_view<Index>(collapsed, "triangles", &Collapsed::triangles);
  def_view<Index>(collapsed, "source", &Collapsed::source);
  def_view<Index>(collapsed, "holder", &Collapsed::holder);
  def_view<Index>(collapsed, "refusals", &Collapsed::refusals);
  collapsed.def_ro("deviation", &Collapsed::deviation)
      .def_ro("accepted", &Collapsed::accepted)
      .def_ro("moved", &Collapsed::moved);
  m.def(
      "collapse",
      [](Points3 points, Faces3 surface, Indices label, Bytes pinned, Bytes left_out, double tolerance, int decimals,
         bool single, Index lids, Progress* progress) {
        nb::gil_scoped_release release;
        return collapse({rows<Vec3>(points), rows<Face>(surface), flat(label), flat(pinned), flat(left_out), lids,
                         tolerance, decimals, single, progress});
      },
      "points"_a, "surface"_a, "label"_a, "pinned"_a, "left_out"_a, "tolerance"_a, "decimals"_a, "single"_a,
      "lids"_a = 0, "progress"_a = nb::none());
  m.def(
      "find_rows",
      [](Faces3 triangles, Indices facet_of_triangle, Faces3 faces, const RowArrays& face_rows, Indices facet_of_face,
         Indices group_of_facet, Indices part_of_facet, Bytes unchanged, Bytes kept) {
        FoundRows found;
        {
          nb::gil_scoped_release release;
          found = find_rows(rows<Face>(triangles), flat(facet_of_triangle), rows<Face>(faces), seen(&face_rows),
                            flat(facet_of_face), flat(group_of_facet), flat(part_of_facet), flat(unchanged), flat(kept));
        }
        return std::tuple(give<Index>(std::move(found.rows)), give<Index>(std::move(found.foreign)));
      },
      "triangles"_a, "facet_of_triangle"_a, "faces"_a, "rows"_a, "facet_of_face"_a, "group_of_facet"_a,
      "part_of_facet"_a, "unchanged"_a, "kept"_a);
}

// Throws where the kernel's preconditions do not hold; who calls then says which rows are to blame.
void check_finite(std::span<const double> numbers) {
  double sum = 0.0;  // not a number as soon as any x * 0 is not 0
  for (const double number : numbers) sum += number * 0.0;
  if (sum != 0.0) throw nb::value_error("not finite");
}
void check_range(std::span<const Index> indices, std::size_t count) {
  bool within = true;
  for (const Index index : indices) within &= static_cast<std::size_t>(index) < count;
  if (!within) throw nb::index_error("index out of range");
}

void check_offsets(std::span<const std::int64_t> offsets, std::size_t count) {
  bool rising = offsets.empty() || (offsets.front() >= 0 && offsets.back() <= static_cast<std::int64_t>(count));
  for (std::size_t i = 1; i < offsets.size(); ++i) rising &= offsets[i - 1] <= offsets[i];
  if (!rising) throw nb::index_error("offsets out of range, or not rising");
}

void bind_distances(nb::module_& m) {
  const auto distances = [](const FaceTree& tree, const Points3& queries) {
    std::vector<double> found;
    {
      nb::gil_scoped_release release;
      found = tree.distances(rows<Vec3>(queries));
    }
    return give<double>(std::move(found));
  };
  nb::class_<FaceTree>(m, "FaceTree")
      .def(
          "__init__",
          [](FaceTree* self, Points3 points, Faces3 faces) {
            check_range({faces.data(), faces.size()}, points.shape(0));
            nb::gil_scoped_release release;
            new (self) FaceTree(rows<Vec3>(points), rows<Face>(faces));
          },
          "points"_a, "faces"_a)
      .def("distances", distances, "queries"_a)
      .def(
          "farthest",
          [](const FaceTree& tree, Points3 queries, double limit) {
            nb::gil_scoped_release release;
            return tree.farthest(rows<Vec3>(queries), limit);
          },
          "queries"_a, "limit"_a);
  m.def(
      "distances",
      [distances](Points3 queries, Points3 points, Faces3 faces) {
        check_range({faces.data(), faces.size()}, points.shape(0));
        std::optional<FaceTree> tree;
        {
          nb::gil_scoped_release release;
          tree.emplace(rows<Vec3>(points), rows<Face>(faces));
        }
        return distances(*tree, queries);
      },
      "queries"_a, "points"_a, "faces"_a);
}

void bind_crossings(nb::module_& m) {
  m.def(
      "find_crossings",
      [](Points3 points, Faces3 faces, std::optional<Bytes> wanted) {
        check_range({faces.data(), faces.size()}, points.shape(0));
        if (wanted && wanted->shape(0) != faces.shape(0)) throw nb::value_error("one flag per face");
        std::vector<std::array<Index, 2>> found;
        {
          nb::gil_scoped_release release;
          const std::vector<std::uint8_t> all(wanted ? 0 : faces.shape(0), 1);
          found = find_crossings(rows<Vec3>(points), rows<Face>(faces), wanted ? flat(*wanted) : std::span(all));
        }
        return give<Index>(std::move(found));
      },
      "points"_a, "faces"_a, "wanted"_a = nb::none());
}

// Signs of a predicate over rows of equal length.
template <class Struct, class Predicate, class Array, class... Arrays>
auto signs(const Predicate& predicate, const Array& first, const Arrays&... rest) {
  const std::size_t count = first.shape(0);
  if (((rest.shape(0) != count) || ...)) throw nb::value_error("arrays of different lengths");
  std::vector<std::int8_t> result(count);
  for (std::size_t i = 0; i < count; ++i)
    result[i] = static_cast<std::int8_t>(predicate(rows<Struct>(first)[i], rows<Struct>(rest)[i]...));
  return give<std::int8_t>(std::move(result));
}

// (crossing segments or None, points, triangles, neighbours, point of each input point, pieces,
// statistics); nothing after the points counts where segments cross.
auto triangulate(const Points2& points, const Pairs& segments, bool carve, bool split_crossings,
                 const std::optional<Doubles>& lift) {
  check_finite({points.data(), points.size()});
  check_range({segments.data(), segments.size()}, points.shape(0));
  if (lift && lift->shape(0) != points.shape(0)) throw nb::value_error("one lift per point");
  if (lift) check_finite(flat(*lift));
  // Small inputs share one workspace per thread; a large one gives its memory back.
  constexpr std::size_t small = 10000;
  static thread_local Triangulator shared;
  std::optional<Triangulator> own;
  if (points.shape(0) > small) own.emplace();
  Triangulator& triangulator = own ? *own : shared;
  Status status;
  {
    nb::gil_scoped_release release;
    status = triangulator.run(rows<Point2>(points), rows<Triangulator::Segment>(segments),
                              {carve, split_crossings, lift ? lift->data() : nullptr});
  }
  std::optional<std::tuple<Index, Index>> crossing;
  if (status == Status::crossing) crossing = {triangulator.crossing()[0], triangulator.crossing()[1]};
  const Statistics& counts = triangulator.statistics();
  Triangulator::Result result = triangulator.release();
  return std::tuple(
      crossing, give<double>(std::move(result.points)), give<Index>(std::move(result.triangles)),
      give<Index>(std::move(result.neighbours)), give<Index>(std::move(result.point_of_input)),
      give<Index>(std::move(result.pieces)),
      row_of(counts));
}

void bind_triangulation(nb::module_& m) {
  m.def("triangulate", &triangulate, "points"_a, "segments"_a, "carve"_a, "split_crossings"_a,
        "lift"_a = nb::none());
  m.def(
      "triangulate_polygons",
      [](Points3 points, In<std::int64_t, nb::shape<-1>> offsets, Indices corners) {
        check_range(flat(corners), points.shape(0));
        check_offsets(flat(offsets), corners.shape(0));
        PolygonFaces result;
        {
          nb::gil_scoped_release release;
          result = triangulate_polygons(rows<Point3>(points), flat(offsets), flat(corners));
        }
        return std::tuple(give<Index>(std::move(result.faces)), give<Index>(std::move(result.polygon_of_face)));
      },
      "points"_a, "offsets"_a, "corners"_a);
  m.def(
      "orient2d", [](Points2 a, Points2 b, Points2 c) { return signs<Point2>(orient2d, a, b, c); }, "a"_a, "b"_a,
      "c"_a);
  m.def(
      "direction_by_poles",
      [](Points2 a, Points2 b, Points2 c) { return signs<Point2>(direction_by_poles, a, b, c); }, "a"_a, "b"_a,
      "c"_a);
  m.def(
      "incircle",
      [](Points2 a, Points2 b, Points2 c, Points2 d) { return signs<Point2>(incircle, a, b, c, d); }, "a"_a, "b"_a,
      "c"_a, "d"_a);
  m.def(
      "orient3d",
      [](Points3 a, Points3 b, Points3 c, Points3 d) { return signs<Point3>(orient3d, a, b, c, d); }, "a"_a, "b"_a,
      "c"_a, "d"_a);
}

}  // namespace
}  // namespace bldsimp

NB_MODULE(_core, m) {
  m.doc() = "bldsimp's kernels";
  m.def(
      "limit_threads",
      [](std::size_t most) {
        if (most == 0) throw nb::value_error("at least one thread");
        bldsimp::most_threads = most;
      },
      "most"_a);
  bldsimp::bind_mesh(m);
  bldsimp::bind_distances(m);
  bldsimp::bind_crossings(m);
  bldsimp::bind_triangulation(m);
}
