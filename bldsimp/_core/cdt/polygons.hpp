// Triangulate polygons in space, as files hold them: concave, not quite plane, touching themselves.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

struct PolygonFaces {
  std::vector<Face> faces;
  std::vector<Index> polygon_of_face;
};

// Triangulates each polygon, corners[offsets[i]] .. corners[offsets[i + 1]], in its best plane: the
// constrained Delaunay triangulation of its outline, with the polygon's winding and no new point.
// Every edge of the outline is an edge of a face and runs the polygon's way, so that neighbors
// still match; a corner that touches another edge of the outline costs a face of no area. What goes
// out and back over the same points is no edge. An outline that crosses itself is cut ear by ear. Fewer
// than three different positions: no face.
// Preconditions: finite points, rising offsets, corners in range. O(n log n) per polygon, O(n^2) or
// worse for one that crosses itself.
PolygonFaces triangulate_polygons(Points points, std::span<const std::int64_t> offsets, Indices corners);

}  // namespace bldsimp
