// Rows: which row of the file each corner of the result reads its attributes from.
#pragma once

#include <span>
#include <vector>

#include "vec3.hpp"

namespace bldsimp {

// For each corner of `triangles` the least input row at that point that a face of the same facet uses.
// Every triangle's points are points of its facet's faces. O(faces + triangles).
std::vector<Face> find_rows(std::span<const Face> triangles, std::span<const Index> facet_of_triangle,
                            std::span<const Face> faces, std::span<const Face> face_rows,
                            std::span<const Index> facet_of_face, std::span<const std::uint8_t> kept);

}  // namespace bldsimp
