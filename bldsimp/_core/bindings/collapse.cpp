// Bind `details/` and `collapse/`: bodies, features, edge collapses.
#include "collapse/collapse.hpp"

#include "bindings/cast.hpp"
#include "collapse/bodies.hpp"
#include "collapse/redundant_bodies.hpp"
#include "details/features.hpp"

namespace bldsimp {

void bind_collapse(nb::module_& m) {
  m.def("find_bodies", unlocked(&find_bodies), "points"_a, "faces"_a);
  m.def("find_redundant_bodies", unlocked(&find_redundant_bodies), "points"_a, "faces"_a, "body"_a, "pinned"_a,
        "limit"_a);

  nb::class_<FeatureRemoval> removal(m, "FeatureRemoval");
  def_views(removal, "points", &FeatureRemoval::points, "left_out", &FeatureRemoval::left_out, "faces",
            &FeatureRemoval::faces, "parent", &FeatureRemoval::parent, "boxes", &FeatureRemoval::boxes, "kinds",
            &FeatureRemoval::kinds, "places", &FeatureRemoval::places, "triangles", &FeatureRemoval::triangles);
  removal.def_ro("kept_by_label", &FeatureRemoval::kept_by_label);
  m.def("remove_features",
        unlocked([](Points points, Faces faces, Indices label, Indices part, Flags has_many_rows, Flags stays,
                    Flags left_out, double limit, double flat, int decimals, bool single, bool keep_topology,
                    Index most_triangles) {
          return remove_features({points,
                                  faces,
                                  label,
                                  part,
                                  has_many_rows,
                                  stays,
                                  left_out,
                                  limit,
                                  flat,
                                  {decimals, single},
                                  keep_topology,
                                  most_triangles});
        }),
        "points"_a, "faces"_a, "label"_a, "part"_a, "has_many_rows"_a, "stays"_a, "left_out"_a, "limit"_a, "flat"_a,
        "decimals"_a, "single"_a, "keep_topology"_a, "most_triangles"_a);

  nb::class_<Progress>(m, "Progress").def(nb::init<>()).def_prop_ro("removed", [](const Progress& p) {
    return p.removed.load();
  });
  nb::class_<CollapseResult> result(m, "CollapseResult");
  def_views(result, "points", &CollapseResult::points, "triangles", &CollapseResult::triangles, "source",
            &CollapseResult::source, "holder", &CollapseResult::holder, "refusals", &CollapseResult::refusals);
  result.def_ro("deviation", &CollapseResult::deviation)
      .def_ro("accepted", &CollapseResult::accepted)
      .def_ro("moved", &CollapseResult::moved);
  m.def("collapse",
        unlocked([](Points points, Faces surface, Indices label, Flags pinned, Flags left_out, double tolerance,
                    int decimals, bool single, Index fill_count, Progress* progress, Flags fixed, Points positions) {
          return collapse({points, surface, label, pinned, left_out, fill_count, tolerance, decimals, single, progress,
                           fixed, positions});
        }),
        "points"_a, "surface"_a, "label"_a, "pinned"_a, "left_out"_a, "tolerance"_a, "decimals"_a, "single"_a,
        "fill_count"_a = 0, "progress"_a = nb::none(), "fixed"_a.none() = nb::none(),
        "positions"_a.none() = nb::none());
}

}  // namespace bldsimp
