// Weld rows of a file to points, and faces to triples of points. Both come in an order that depends on coordinates
// alone, so that no later stage can depend on the order of the file.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

struct WeldResult {
  Array<Vec3> points;         // distinct positions that a face uses, in lexicographic order
  Array<Index> point_of_row;  // -1 where no face uses the row
  Array<Face> faces;          // least point first, winding kept; in lexicographic order
  Array<Index> source;        // input face of each face
  Array<Index> class_of_row;  // where faces have copies: rows with equal numbers count as one; else empty
  Index degenerate = 0;       // faces dropped since they repeat a point
  Index duplicate = 0;        // faces dropped since they copy another with the same winding
  double moved = 0;           // greatest distance between a row and its point
};

// A flag for each of `count` rows: whether a face uses it.
Array<std::uint8_t> mark_used(Faces faces, std::size_t count);

// Points nearer than `distance` to an earlier point (in lexicographic order) become that point; with
// 0, only equal points are one. Rows of `faces` must be in range and finite. Faces copy one another only if they
// are of the same layer (all are where it is empty). O(n log n).
WeldResult weld(Points rows, Faces faces, double distance, Indices layer);

}  // namespace bldsimp
