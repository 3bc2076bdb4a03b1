// Slide a facet into the plane of one beside it, so that the step between them goes.
#pragma once

#include "details/loop_closing.hpp"

namespace bldsimp {

struct FacetSlide {
  std::vector<Index> gone;  // faces, sorted: of all facets at the points that move
  Caps caps;                // what takes their place
};

// Larger parallel facets within `reach` of a small facet, beyond a strip; the nearest plane first.
std::vector<Index> find_slide_planes(const FacetGraph& graph, Index facet, double reach);

// Moves each point of a facet along the planes of the other facets at it, by at most `reach`, into the plane of another
// one. A point that comes to a neighbor becomes one with it. Nothing where that is not possible.
std::optional<FacetSlide> slide_facet(const FacetGraph& graph, Triangulator& triangulator, Index facet, Index plane,
                                      double reach);

}  // namespace bldsimp
