// Rows: which row of the file each corner of the result reads its attributes from.
#pragma once

#include <span>
#include <vector>

#include "vec3.hpp"

namespace bldsimp {

// Of the rows of an input face, the one at a point of it.
inline Index row_at(Index point, const Face& input, std::span<const Index> point_of_row) {
  return point_of_row[input[0]] == point ? input[0] : point_of_row[input[1]] == point ? input[1] : input[2];
}

// The file's rows at the corners of welded faces. Without any (faces that are no file's) points are rows.
struct Rows {
  std::span<const Face> input;
  std::span<const Index> point_of_row, source, class_of_row;  // as in `Welded`

  Index at(Index face, Index point) const {
    return input.empty() ? point : row_at(point, input[source[face]], point_of_row);
  }
  // The same for rows that count as one.
  Index class_at(Index face, Index point) const {
    const Index row = at(face, point);
    return class_of_row.empty() ? row : class_of_row[row];
  }
};

// Rows of corners, and the corners (three times the triangle, plus 0 to 2) whose rows are another group's.
struct FoundRows {
  std::vector<Face> rows;
  std::vector<Index> foreign;
};

// Triangles of facets that are `unchanged` are faces of them, and keep the rows of those. For each corner of the others
// the least input row at that point that a face of the same facet uses, or of the
// same group of facets where none of the facet does, or of the same part. Every triangle's points are points of its
// part's faces. O(faces + triangles).
FoundRows find_rows(std::span<const Face> triangles, std::span<const Index> facet_of_triangle,
                    std::span<const Face> faces, const Rows& rows, std::span<const Index> facet_of_face,
                    std::span<const Index> group_of_facet, std::span<const Index> part_of_facet,
                    std::span<const std::uint8_t> unchanged, std::span<const std::uint8_t> kept);

}  // namespace bldsimp
