// Find the bodies of a surface: what can be removed as a whole.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

// The body of each face: its least face. Edges connect faces. Where more than two faces meet, an edge connects those
// that bound the same matter, which lies behind faces: so solids that touch are bodies of their own. Where that
// leaves faces over, the edge connects none. An inner shell, which is closed, faces inwards and lies within a closed
// body, belongs to that one. Nearly linear, plus the faces above a point for each inner shell.
Array<Index> find_bodies(Points points, Faces faces);

}  // namespace bldsimp
