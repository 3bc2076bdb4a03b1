// Find the bodies of a surface: what can be removed as a whole.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

// The body of each face: its least face. Faces hang together by edges; where more than two meet, each goes with the
// one that bounds the same matter, which lies behind faces, so that solids that touch are bodies of their own; where
// that leaves faces over, none of them hang together there. Nearly linear.
Array<Index> find_bodies(Points points, Faces faces);

}  // namespace bldsimp
