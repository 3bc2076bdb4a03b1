// Bound the distance between two fans of faces over the same ring.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

// The farthest that any point of the fan around `to` is from the fan around `from`, at most: both are seen along the
// mean normal of the latter, where each covers what the ring encloses exactly once. Infinite where one of them does
// not. Ring edges are given as the faces around `from` have them; `to` may be a point of the ring. O(n^2) for n edges.
double bound_fan_distance(Vec3 from, Vec3 to, std::span<const std::array<Vec3, 2>> ring);

}  // namespace bldsimp
