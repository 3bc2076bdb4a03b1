// Triangulate what edges enclose in a plane.
#pragma once

#include <optional>

#include "cdt/cdt.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

// The triangles that directed edges, with what they enclose on their left as seen against the normal, bound; over the
// points of the edges alone. `place` has the place of each point of `points`, which are sorted. Nothing where the edges
// cross or touch, or enclose no area, or less than they wind round. `rounding` is an area.
std::optional<std::vector<Face>> triangulate_outline(Triangulator& triangulator, Vec3 normal,
                                                     std::span<const Edge> edges, Indices points, Points places,
                                                     double rounding);

}  // namespace bldsimp
