// Triangulate each facet anew from the pieces of its outline, and check that the facets fit together again.
#pragma once

#include "cdt/cdt.hpp"
#include "mesh/vec3.hpp"
#include "planar/facets.hpp"
#include "planar/thin.hpp"

namespace bldsimp {

enum class Outcome : std::uint8_t {
  done,
  unchanged,  // no point of it was dropped: its own triangles stay
  crossing,   // pieces of its outline cross or touch
  mismatch,   // the triangles do not cover what its faces covered, or its folded needles reach too far out of them
};

// An edge at which a facet does not fit.
struct Misfit {
  Index facet, low, high;
  friend auto operator<=>(const Misfit&, const Misfit&) = default;
};

struct Patches {
  std::vector<Face> triangles;
  std::vector<Index> facet_of_triangle;  // in the order in which the facets were asked for
  std::vector<Outcome> outcomes;         // one for each facet asked for
  std::vector<double> reach;             // how far, in its plane, folded needles of each reach out of its triangles
  std::vector<IndexPair> put_back;       // {facet, point}: what may resolve a crossing; sorted
  std::vector<Misfit> trouble;           // pieces that cross or touch, and points (low == high) that lie on one; sorted
  Statistics statistics;                 // of all triangulations
};

// What every facet is made of; plain views, so that nothing is copied between stages.
struct FacetParts {
  Points points;
  Faces faces;
  Indices face_start;  // faces of facet f: face_order[face_start[f]] ..
  Indices face_order;
  std::span<const Plane> planes;
  const Outlines& outlines;
  std::span<const Piece> pieces;  // of all chains, in the order of the chains
  Flags kept;                     // per point
  std::span<const double> reach;  // per facet: greatest reach allowed
};

// Facets in `wanted` are projected along the axis of their normal's greatest component (which leaves
// exactly collinear points exactly collinear), triangulated there so that they are Delaunay in their
// own plane, and checked: every piece is there unsplit, with the facet on its left, and the area agrees
// with what thinning may have changed. Those with keep[facet] return their own faces.
Patches retriangulate(const FacetParts& parts, Indices wanted, Flags keep);

// Piece edges must be used as `expected` tells, all others once each way by one facet, or by a facet and
// its back (see Outlines); no triangle may be there twice. Facets in `keep` are never blamed. Sorted. O(n log n).
std::vector<Misfit> find_misfits(Faces triangles, Indices facet_of_triangle, const PieceEdges& expected, Flags keep,
                                 const Outlines& outlines);

}  // namespace bldsimp
