// Which bodies of a surface the others make needless.
#pragma once

#include <span>
#include <vector>

#include "mesh/vec3.hpp"

namespace bldsimp {

// Marks the faces of bodies that can go: every point of them, and of those that went before, is within `limit` of what
// remains; no edge of what remains is left open or without balance by it. Pinned faces, and the bodies that have some,
// stay, and so does at least one body. `body` is the least face of each body. About O(n log n); the same result
// whatever the number of threads.
std::vector<std::uint8_t> find_redundant_bodies(std::span<const Vec3> points, std::span<const Face> faces,
                                                std::span<const Index> body, std::span<const std::uint8_t> pinned,
                                                double limit);

}  // namespace bldsimp
