// Assign to each corner of the result the row of the file from which it reads its attributes.
#pragma once

#include "mesh/corner_rows.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

// Rows of corners, and the corners (three times the triangle, plus 0 to 2) whose rows are another group's.
struct RowAssignment {
  std::vector<Face> rows;
  std::vector<Index> foreign;
};

// Triangles of facets that are `unchanged` are faces of them, and keep the rows of those. Each corner of the others
// gets the least input row at its point that a face of the same facet uses; where the facet has none, one of the same
// group of facets; else one of the same part. Every triangle's points are points of its part's faces, else this throws
// InternalError. O(faces + triangles).
RowAssignment assign_rows(Faces triangles, Indices facet_of_triangle, Faces faces, const CornerRows& rows,
                          Indices facet_of_face, Indices group_of_facet, Indices part_of_facet, Flags unchanged,
                          Flags kept);

}  // namespace bldsimp
