// Trace outlines: the edges between facets, as chains that are decided once for the whole mesh.
#pragma once

#include "mesh/halfedges.hpp"
#include "mesh/vec3.hpp"
#include "planar/facets.hpp"

namespace bldsimp {

// One facet that runs along a chain: forward where its halfedges point along the chain.
struct FacetUse {
  Index facet;
  bool forward;
  friend auto operator<=>(const FacetUse&, const FacetUse&) = default;
};

// A chain is a maximal polyline between the same facets. It begins at its end with the lower point
// (a closed chain at its chain end, else at its least point, which it repeats at the end).
struct Outlines {
  std::vector<Index> chain_start{0};  // points of chain c: chain_points[chain_start[c]] ..
  std::vector<Index> chain_points;
  std::vector<Index> use_start{0};  // uses of chain c, sorted
  std::vector<FacetUse> uses;
  std::vector<std::uint8_t> is_chain_end;  // per point: an end of a chain, or a point that must stay
  // Points that must stay inside a facet although no chain of it passes them: two sheets touch there.
  std::vector<IndexPair> inner;  // {facet, point}, sorted
  Index touching = 0;            // chain ends that stay only since sheets touch, or share edges, inside of facets
  // Per facet the facet that has the same faces the other way round (a two-sided sheet), or -1.
  std::vector<Index> back;
};

// `frozen` has a flag for each facet; such facets keep all their points, so all their edges are chains.
// `faces` are in the order of `weld`. O(halfedges).
Outlines trace_outlines(Faces faces, Index point_count, const Halfedges& halfedges, const Facets& facets, Flags frozen);

}  // namespace bldsimp
