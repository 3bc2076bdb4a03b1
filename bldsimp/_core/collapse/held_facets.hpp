// Find the facets that keep their planes while edges collapse.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

struct HeldPlane {
  Vec3 normal;
  double offset;  // normal . point
};

// A face of a facet that has sharp or open borders, but may be too small to keep its plane.
struct FlatFace {
  Index face;
  Vec3 normal;  // of the facet
  double sine;  // of the angle within which others are parallel to it
};

struct HeldFacets {
  std::vector<Index> plane_of_face;  // -1 for faces that may turn
  std::vector<HeldPlane> planes;
  std::vector<FlatFace> flat;
  std::vector<double> noticed;  // of each face, the area from which on one in its place is noticed
};

// Finds large facets with sharp or open borders, and narrow ones with sharp borders beside much larger ones. About
// O(n log n).
HeldFacets find_held_facets(Points points, Faces faces, Indices label, double tolerance);

}  // namespace bldsimp
