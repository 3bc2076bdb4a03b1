// Find the facets that keep their planes while edges collapse.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

struct HeldPlane {
  Vec3 normal;
  double offset;  // normal . point
};

struct HeldFacets {
  std::vector<Index> plane_of_face;  // -1 for faces that may turn
  std::vector<HeldPlane> planes;
};

// Finds large facets with sharp or open borders, and narrow ones with sharp borders beside much larger ones. About
// O(n log n).
HeldFacets find_held_facets(Points points, Faces faces, Indices label, double tolerance);

}  // namespace bldsimp
