// Thin: which points of the chains stay, and the straight pieces that replace what goes.
#pragma once

#include <span>
#include <vector>

#include "outlines.hpp"
#include "vec3.hpp"

namespace bldsimp {

// One straight piece of a thinned chain, in the chain's direction.
struct Piece {
  Index from, to;
  Index chain;
  Index farthest;    // the dropped point with the greatest distance to the piece; -1 if none was dropped
  double deviation;  // that distance
};

// Marks in `kept` (per point; on entry: points that must stay) what stays of each chain: ends, and what
// is needed so that every dropped point is within limit[chain] of its piece. A limit of 0 drops exactly
// collinear points only. A closed chain keeps at least three points. O(n log n).
void thin_chains(std::span<const Vec3> points, const Outlines& outlines, std::span<const double> limit,
                 std::span<std::uint8_t> kept);

// The pieces between kept points, chain by chain.
std::vector<Piece> lay_pieces(std::span<const Vec3> points, const Outlines& outlines,
                              std::span<const std::uint8_t> kept);

// The edges that the pieces make, each once, with the uses that the finished mesh must show there.
struct PieceEdges {
  std::vector<std::array<Index, 2>> edges;  // lower end first, sorted
  std::vector<Index> use_start{0};
  std::vector<Use> uses;             // forward: from the lower to the upper end; sorted
  std::vector<Index> clashing;       // points to put back, sorted
  std::vector<Index> healed_pieces;  // pieces that were laid on one another rightly
  Index healed = 0;                  // edges that they make
};

// Pieces of different chains that share both ends are one edge. That is right only if, once opposite
// uses by one facet cancel (it has no width there), one use each way is left: for all others the
// farthest dropped points are in `clashing`.
PieceEdges merge_pieces(std::span<const Piece> pieces, const Outlines& outlines);

}  // namespace bldsimp
