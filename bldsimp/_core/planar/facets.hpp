// Find facets: maximal connected sets of faces in one plane.
#pragma once

#include "mesh/halfedges.hpp"

namespace bldsimp {

struct Plane {
  Vec3 normal;  // unit length, on the side that the faces face; zero where the facet has no area
  double low;   // least and greatest normal . point over ALL points of the facet, about the origin
  double high;
};

struct Facets {
  Array<Index> facet_of_face;
  std::vector<Plane> planes;
  std::vector<std::uint8_t> curved;  // per facet as found: cut out of a surface that is not flat as a whole
};

struct FacetLimits {
  double width;   // greatest allowed high - low; 0 asks for exact coplanarity
  double needle;  // a face whose height is at most this has no plane of its own
  double fold;    // how far a needle that is turned over in the plane may seem to reach out of the other faces
};

// Faces with different labels never share a facet; a face with a negative label is a facet by itself.
// Facets are numbered by their first face. `origin` is near the mesh. Nearly linear.
Facets find_facets(Points points, Faces faces, const Halfedges& halfedges, Indices label, Vec3 origin,
                   const FacetLimits& limits);

// Makes each of `cut` (sorted) a facet by itself; the others keep their numbers.
Facets split_off(const Facets& facets, Indices cut);

// The faces of each facet.
Groups group_faces(const Facets& facets);

}  // namespace bldsimp
