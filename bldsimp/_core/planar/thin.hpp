// Thin chains: find the points that must stay, and the straight pieces that replace the others.
#pragma once

#include "mesh/vec3.hpp"
#include "planar/outlines.hpp"

namespace bldsimp {

// One straight piece of a thinned chain, in the chain's direction.
struct Piece {
  Index from, to;
  Index chain;
  Index farthest;    // the dropped point with the greatest distance to the piece; -1 if none was dropped
  double deviation;  // that distance
};

// A flag for each point: what stays of each chain, which is `keep` (points that must stay), its ends, and what is
// needed so that every dropped point is within limit[chain] of its piece. A limit of 0 drops exactly collinear points
// only. A closed chain keeps at least three points. O(n log n).
std::vector<std::uint8_t> thin_chains(Points points, const Outlines& outlines, std::span<const double> limit,
                                      Flags keep);

// The pieces between kept points, chain by chain. Throws InternalError where an end of a chain is not kept.
std::vector<Piece> lay_pieces(Points points, const Outlines& outlines, Flags kept);

// The edges that the pieces make, each once, with the uses that the finished mesh must show there.
struct PieceEdges {
  std::vector<Edge> edges;  // lower end first, sorted
  std::vector<Index> use_start{0};
  std::vector<FacetUse> uses;        // forward: from the lower to the upper end; sorted
  std::vector<Index> clashing;       // points to put back, sorted
  std::vector<Index> healed_pieces;  // pieces that were laid on one another rightly
  Index healed = 0;                  // edges that they make
};

// Pieces of different chains that share both ends are one edge. That is right only if, once opposite
// uses by one facet cancel (it has no width there), one use each way is left: for all others the
// farthest dropped points are in `clashing`.
PieceEdges merge_pieces(const std::vector<Piece>& pieces, const Outlines& outlines);

}  // namespace bldsimp
