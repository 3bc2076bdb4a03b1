// Bind `collapse/`: bodies, hole filling, edge collapses.
#include "collapse/collapse.hpp"

#include "bindings/cast.hpp"
#include "collapse/bodies.hpp"
#include "collapse/hole_filling.hpp"
#include "collapse/redundant_bodies.hpp"

namespace bldsimp {

void bind_collapse(nb::module_& m) {
  m.def("find_bodies", unlocked(&find_bodies), "points"_a, "faces"_a);
  m.def("find_redundant_bodies", unlocked(&find_redundant_bodies), "points"_a, "faces"_a, "body"_a, "pinned"_a,
        "limit"_a);

  nb::class_<HoleFilling> filling(m, "HoleFilling");
  def_views(filling, "faces", &HoleFilling::faces, "beside", &HoleFilling::beside);
  filling.def_ro("closed", &HoleFilling::closed);
  m.def("fill_holes", unlocked(&fill_holes), "points"_a, "faces"_a, "label"_a, "pinned"_a, "limit"_a);

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
                    int decimals, bool single, Index fill_count, Progress* progress, Flags fixed) {
          return collapse(
              {points, surface, label, pinned, left_out, fill_count, tolerance, decimals, single, progress, fixed});
        }),
        "points"_a, "surface"_a, "label"_a, "pinned"_a, "left_out"_a, "tolerance"_a, "decimals"_a, "single"_a,
        "fill_count"_a = 0, "progress"_a = nb::none(), "fixed"_a.none() = nb::none());
}

}  // namespace bldsimp
