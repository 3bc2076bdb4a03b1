// Find the bodies of a surface that the others make redundant.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

// Marks the faces of bodies that can be removed: every point of them, and of bodies removed before, is within `limit`
// of the remaining ones, and no remaining edge becomes open or unbalanced. A holder must be within 45 degrees of its
// face and lie under it, except where `find_holder_normals` asks for nothing. Bodies with a pinned face stay, and so
// does at least one body. `body` is the least face of each body. About O(n log n); the same result whatever the number
// of threads.
std::vector<std::uint8_t> find_redundant_bodies(Points points, Faces faces, Indices body, Flags pinned, double limit);

}  // namespace bldsimp
