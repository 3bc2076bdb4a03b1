// Find charts: faces on which the attributes of rows (texture coordinates, colors) are one affine map of the position.
#pragma once

#include "mesh/corner_rows.hpp"
#include "mesh/halfedges.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

// Attributes of the file's rows: `limits.size()` columns. Column c of part p is worth steps[p * columns + c] steps a
// unit, and may be off its map by half of limits[c] steps either way.
struct AttributeColumns {
  std::span<const double> values, steps, limits;
};

struct Charts {
  Array<Index> chart_of_face;  // charts are numbered in the order of their largest faces, group by group
  std::vector<double> maps;    // per chart and column: change of the value along x, y and z, value at zero
  std::vector<double> spans;   // per chart and column: greatest minus least difference from the map, in steps
};

// Faces share a chart only if they are of the same group and hang together across twins. A group whose faces all fit
// one map is one chart; else charts grow from the largest faces. `order` has the faces group by group, those of
// group g from start[g] on. A map does not change in directions that tell nothing about it. Linear where groups are
// charts; else nearly linear in faces, times the charts that reach each.
Charts find_charts(Points points, Faces faces, const Halfedges& halfedges, Indices start, Indices order,
                   const CornerRows& rows, Indices part_of_face, const AttributeColumns& columns);

// The sets of faces that hang together across twins at both of whose ends the rows' normals turn by no more than an
// angle, told by its cosine. Ends without normals, and faces no higher than `needle`, count as smooth. Per face the
// least face of its set.
Array<Index> find_smooth(Points points, Faces faces, const Halfedges& halfedges, const CornerRows& rows, Points normals,
                         double cosine, double needle);

}  // namespace bldsimp
