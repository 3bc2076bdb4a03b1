// Tell which row of the file a corner of a welded face reads.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

// Of the rows of an input face, the one at a point of it.
inline Index row_at(Index point, const Face& input, Indices point_of_row) {
  return point_of_row[input[0]] == point ? input[0] : point_of_row[input[1]] == point ? input[1] : input[2];
}

// The file's rows at the corners of welded faces. Without any (faces of no file) points are rows.
struct CornerRows {
  Faces input;
  Indices point_of_row, source, class_of_row;  // as in `WeldResult`

  Index at(Index face, Index point) const {
    return input.empty() ? point : row_at(point, input[source[face]], point_of_row);
  }
  // The same for rows that count as one.
  Index class_at(Index face, Index point) const {
    const Index row = at(face, point);
    return class_of_row.empty() ? row : class_of_row[row];
  }
};

}  // namespace bldsimp
