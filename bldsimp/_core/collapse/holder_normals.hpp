// Tell which faces of a body only something roughly parallel may hold.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

// For each face of a body its normal, or zero where anything near may hold it: where no side of the body's oriented box
// is over twice the limit, and on faces that are no wider than the limit. A rim may be twice as wide: its middle has
// holders on either side. Nearly linear.
std::vector<Vec3> find_holder_normals(Points points, Faces body, double limit);

}  // namespace bldsimp
