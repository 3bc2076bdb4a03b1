// Fill a loop of open edges that lies in no plane.
#pragma once

#include <optional>

#include "details/facet_graph.hpp"

namespace bldsimp {

// Faces over the points of a loop, cut off by the shortest diagonals first. Nothing where a face would lie folded on
// its neighbor, where a diagonal is an edge already, or where the loop passes a point twice. O(n log n).
std::optional<std::vector<Face>> fill_loop(const FacetGraph& graph, const Loop& loop);

}  // namespace bldsimp
