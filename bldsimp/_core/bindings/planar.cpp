// Bind `planar/`: facets, charts, outlines, their thinning and new triangles.
#include "bindings/corner_rows.hpp"
#include "bindings/statistics.hpp"
#include "planar/charts.hpp"
#include "planar/conform.hpp"
#include "planar/facets.hpp"
#include "planar/outlines.hpp"
#include "planar/retriangulate.hpp"
#include "planar/row_assignment.hpp"
#include "planar/thin.hpp"

namespace bldsimp {
template <>
struct ItemTraits<Plane> {
  using Scalar = double;
};
template <>
struct ItemTraits<Misfit> {
  using Scalar = Index;
};

namespace {

using Pieces = std::vector<Piece>;

void bind_facets(nb::module_& m) {
  nb::class_<Facets> facets(m, "Facets");
  def_views(facets, "facet_of_face", &Facets::facet_of_face, "planes", &Facets::planes, "curved", &Facets::curved);
  facets.def(
      "__init__",
      [](Facets* self, Indices facet_of_face, std::span<const Plane> planes) {
        new (self) Facets{{facet_of_face.begin(), facet_of_face.end()}, {planes.begin(), planes.end()}, {}};
      },
      "facet_of_face"_a, "planes"_a);
  m.def("find_facets",
        unlocked([](Points points, Faces faces, const Halfedges& halfedges, Indices label,
                    std::tuple<double, double, double> origin, double width, double needle, double fold) {
          const auto [x, y, z] = origin;
          return find_facets(points, faces, halfedges, label, {x, y, z}, {width, needle, fold});
        }),
        "points"_a, "faces"_a, "halfedges"_a, "label"_a, "origin"_a, "width"_a, "needle"_a, "fold"_a);
  m.def("group_faces", unlocked_pair(&group_faces), "facets"_a);
  m.def("split_off", unlocked(&split_off), "facets"_a, "cut"_a);
}

void bind_charts(nb::module_& m) {
  using Table = nb::ndarray<const double, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
  nb::class_<Charts> charts(m, "Charts");
  def_views(charts, "chart_of_face", &Charts::chart_of_face, "maps", &Charts::maps, "spans", &Charts::spans);
  m.def(
      "find_charts",
      [](Points points, Faces faces, const Halfedges& halfedges, Indices start, Indices order, const CornerRows& rows,
         Indices part_of_face, Table values, Table steps, std::span<const double> limits) {
        if (values.shape(1) != limits.size() || steps.shape(1) != limits.size())
          throw nb::value_error("one limit, and one number of steps, for each column");
        nb::gil_scoped_release release;
        return find_charts(points, faces, halfedges, start, order, rows, part_of_face,
                           {{values.data(), values.size()}, {steps.data(), steps.size()}, limits});
      },
      "points"_a, "faces"_a, "halfedges"_a, "start"_a, "order"_a, "rows"_a, "part_of_face"_a, "values"_a, "steps"_a,
      "limits"_a);
  m.def("find_smooth", unlocked(&find_smooth), "points"_a, "faces"_a, "halfedges"_a, "rows"_a, "normals"_a, "cosine"_a,
        "needle"_a);
}

void bind_outlines(nb::module_& m) {
  nb::class_<Outlines> outlines(m, "Outlines");
  def_views(outlines, "chain_start", &Outlines::chain_start, "chain_points", &Outlines::chain_points, "use_start",
            &Outlines::use_start, "is_chain_end", &Outlines::is_chain_end, "inner", &Outlines::inner, "back",
            &Outlines::back);
  outlines.def_ro("touching", &Outlines::touching);
  const auto uses = [](const Outlines& o) -> const auto& { return o.uses; };
  def_column(outlines, "use_facet", uses, &FacetUse::facet);
  def_column(outlines, "use_forward", uses, &FacetUse::forward);
  m.def("trace_outlines", unlocked(&trace_outlines), "faces"_a, "point_count"_a, "halfedges"_a, "facets"_a, "frozen"_a);
  m.def("thin_chains", unlocked(&thin_chains), "points"_a, "outlines"_a, "limit"_a, "keep"_a);

  nb::class_<Pieces> pieces(m, "Pieces");
  const auto all = [](const Pieces& p) -> const auto& { return p; };
  def_column(pieces, "begin", all, &Piece::from);
  def_column(pieces, "end", all, &Piece::to);
  def_column(pieces, "chain", all, &Piece::chain);
  def_column(pieces, "farthest", all, &Piece::farthest);
  def_column(pieces, "deviation", all, &Piece::deviation);
  m.def("lay_pieces", unlocked(&lay_pieces), "points"_a, "outlines"_a, "kept"_a);

  nb::class_<PieceEdges> edges(m, "PieceEdges");
  def_views(edges, "edges", &PieceEdges::edges, "clashing", &PieceEdges::clashing, "healed_pieces",
            &PieceEdges::healed_pieces);
  edges.def_ro("healed", &PieceEdges::healed);
  m.def("merge_pieces", unlocked(&merge_pieces), "pieces"_a, "outlines"_a);
}

void bind_retriangulation(nb::module_& m) {
  nb::class_<Patches> patches(m, "Patches");
  def_views(patches, "triangles", &Patches::triangles, "facet_of_triangle", &Patches::facet_of_triangle, "outcomes",
            &Patches::outcomes, "reach", &Patches::reach, "put_back", &Patches::put_back, "trouble", &Patches::trouble);
  patches.def_prop_ro("statistics", [](const Patches& p) { return row_of(p.statistics); });
  m.def("retriangulate",
        unlocked([](Points points, Faces faces, Indices face_start, Indices face_order, const Facets& facets,
                    const Outlines& outlines, const Pieces& pieces, Flags kept, std::span<const double> reach,
                    Indices wanted, Flags keep) {
          const FacetParts parts{points, faces, face_start, face_order, facets.planes, outlines, pieces, kept, reach};
          return retriangulate(parts, wanted, keep);
        }),
        "points"_a, "faces"_a, "face_start"_a, "face_order"_a, "facets"_a, "outlines"_a, "pieces"_a, "kept"_a,
        "reach"_a, "wanted"_a, "keep"_a);
  m.def("find_misfits", unlocked(&find_misfits), "triangles"_a, "facet_of_triangle"_a, "expected"_a, "keep"_a,
        "outlines"_a);
  m.def("assign_rows", unlocked_pair(&assign_rows), "triangles"_a, "facet_of_triangle"_a, "faces"_a, "rows"_a,
        "facet_of_face"_a, "group_of_facet"_a, "part_of_facet"_a, "unchanged"_a, "kept"_a);

  nb::class_<ConformResult> conformed(m, "ConformResult");
  def_views(conformed, "made", &ConformResult::made, "triangles", &ConformResult::triangles, "facet_of_triangle",
            &ConformResult::facet_of_triangle, "facets", &ConformResult::facets);
  conformed.def_prop_ro("statistics", [](const ConformResult& c) { return row_of(c.statistics); });
  m.def("conform",
        unlocked([](Points points, std::span<const Plane> planes, const Outlines& outlines, const Pieces& pieces,
                    Faces triangles, Indices facet_of_triangle, Flags keep) {
          return conform({points, planes, outlines, pieces, triangles, facet_of_triangle, keep});
        }),
        "points"_a, "planes"_a, "outlines"_a, "pieces"_a, "triangles"_a, "facet_of_triangle"_a, "keep"_a);
}

}  // namespace

void bind_planar(nb::module_& m) {
  bind_facets(m);
  bind_charts(m);
  bind_outlines(m);
  bind_retriangulation(m);
}

}  // namespace bldsimp
