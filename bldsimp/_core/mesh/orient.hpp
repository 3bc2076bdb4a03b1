// Find the faces to turn so that neighbors agree and closed components face outwards.
#pragma once

#include "mesh/halfedges.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

// Components are joined across twins, across edges of two faces that run the same way, and where more
// faces meet across those of two that share the file's own rows. Where a component can be oriented, the
// faces that stand against the larger area are turned; a closed component that then encloses a negative
// volume is turned as a whole, unless it lies within an odd number of others (a cavity). Components with a
// `fixed` face, and those that cannot be oriented, stay as they are.
// Returns the faces to turn, sorted. Nearly linear, plus the faces above a point for each inside-out component.
std::vector<Index> find_misoriented(Points points, Faces faces, const Halfedges& halfedges, const CornerRows& rows,
                                    Flags fixed);

}  // namespace bldsimp
