// Close boundary loops with faces.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

struct HoleFilling {
  std::vector<Face> faces;
  std::vector<Index> beside;  // of each of them, a face that the loop bounds
  Index closed = 0;           // loops
};

// Closes those loops of open edges that can be closed within a limit of the faces: by faces between points of the
// loop alone, of which every point is within `limit` of the given ones, which do not lie folded on these, cross none
// and share no edge with them but the loop. Loops that touch one another, or that bound faces of several labels or
// pinned ones, stay. About O(n log n).
HoleFilling fill_holes(Points points, Faces faces, Indices label, Flags pinned, double limit);

}  // namespace bldsimp
