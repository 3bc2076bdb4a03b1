// Find the bodies of a surface: what can be removed as a whole.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

// The body of each face: its least face. Edges connect faces. Where more than two faces meet, an edge connects those
// that bound the same matter, which lies behind faces: so solids that touch are bodies of their own. Where that
// leaves faces over, the edge connects none. Nearly linear.
Array<Index> find_bodies(Points points, Faces faces);

}  // namespace bldsimp
