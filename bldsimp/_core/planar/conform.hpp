// Triangulate facets by the article's standard method, which the improved one is compared with.
#pragma once

#include "cdt/cdt.hpp"
#include "mesh/vec3.hpp"
#include "planar/facets.hpp"
#include "planar/thin.hpp"

namespace bldsimp {

// The improved method's result, from which the standard one starts.
struct ConformParts {
  Points points;
  std::span<const Plane> planes;
  const Outlines& outlines;
  std::span<const Piece> pieces;
  Faces triangles;
  Indices facet_of_triangle;
  Flags keep;  // facets whose triangles are not ours to choose
};

// How a facet got its triangles. All but the first have those of the improved method, cut where pieces were.
enum class Conformity : std::uint8_t {
  delaunay,  // unconstrained, every piece an edge
  kept,      // its faces stayed, or it has no plane or outline
  stopped,   // it had more than `most_times` its points, and still a piece was no edge
  crossing,  // cutting made pieces cross or touch by rounding, or its own faces overlap
  clash,     // its triangles would lay an inner edge on another facet's
};
inline constexpr Index most_times = 50;

struct ConformResult {
  std::vector<Vec3> made;  // points made by cutting pieces; they are numbered behind the given ones
  std::vector<Face> triangles;
  std::vector<Index> facet_of_triangle;  // rising
  std::vector<Conformity> facets;
  Statistics statistics;  // of all triangulations
};

// Triangulates each facet by the points of its pieces alone, cuts the pieces that are no edges, and again,
// until all are. A piece is cut in its middle; one that ends where pieces of a facet meet under less than 60
// degrees on a sphere about that point, whose radius is the power of two nearest to half: pieces that meet
// there end on the same spheres, so that none of them cuts the others for ever. A piece belongs to all
// facets along it, so all see the new points. Directions are told by determinants, and nothing is swapped
// for a segment. Depends on the coordinates alone.
//
// A facet's new triangles must have the rim of its triangles in the improved method, cut alike: thus edges are
// used as often as there. Of four points on one circle, the diagonal holds the least, even where a piece is the
// other one, which is then cut.
// Source: J. Ruppert, "A Delaunay Refinement Algorithm for Quality 2-Dimensional Mesh Generation", 1995
// (spheres about corners).
ConformResult conform(const ConformParts& parts);

}  // namespace bldsimp
