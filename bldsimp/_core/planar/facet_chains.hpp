// List the chains along each facet, and the pieces that replace them.
#pragma once

#include <iterator>

#include "planar/projection.hpp"
#include "planar/thin.hpp"

namespace bldsimp {

// Which chains run along a facet, and which pieces replace a chain.
struct FacetChains {
  FacetChains(const Outlines& outlines, std::span<const Piece> pieces, std::size_t facets)
      : use_start(facets + 1, 0), piece_start(outlines.chain_start.size(), 0) {
    for (const FacetUse& use : outlines.uses) ++use_start[use.facet + 1];
    std::partial_sum(use_start.begin(), use_start.end(), use_start.begin());
    chain_uses.resize(outlines.uses.size());
    std::vector<Index> cursor(use_start.begin(), use_start.end() - 1);
    for (std::size_t c = 0; c + 1 < outlines.use_start.size(); ++c)
      for (Index u = outlines.use_start[c]; u < outlines.use_start[c + 1]; ++u)
        chain_uses[cursor[outlines.uses[u].facet]++] = {static_cast<Index>(c), outlines.uses[u].forward};
    for (const Piece& piece : pieces) ++piece_start[piece.chain + 1];
    std::partial_sum(piece_start.begin(), piece_start.end(), piece_start.begin());
  }
  // Calls visit(piece, forward) for the pieces along a facet.
  template <class Visit>
  void for_pieces(Index facet, Visit visit) const {
    for (Index u = use_start[facet]; u < use_start[facet + 1]; ++u)
      for (Index i = piece_start[chain_uses[u].first]; i < piece_start[chain_uses[u].first + 1]; ++i)
        visit(i, chain_uses[u].second);
  }

  std::vector<Index> use_start;
  std::vector<std::pair<Index, bool>> chain_uses;  // {chain, forward}
  std::vector<Index> piece_start;
};

// Both sides of a sheet are triangulated in the projection of the first, so that ties among points on one
// circle fall alike and the diagonals of one side never cross those of the other.
inline Index front_of(const Outlines& outlines, Index facet) {
  const Index back = outlines.back[facet];
  return back >= 0 && back < facet ? back : facet;
}
inline bool is_behind(const Outlines& outlines, Index facet) { return front_of(outlines, facet) != facet; }

// Points that must stay inside a facet although no chain of it passes them, as rows of `inner`.
inline std::span<const IndexPair> inner_of(const Outlines& outlines, Index facet) {
  const auto& inner = outlines.inner;
  return {std::lower_bound(inner.begin(), inner.end(), IndexPair{facet, -1}),
          std::lower_bound(inner.begin(), inner.end(), IndexPair{facet + 1, -1})};
}

// The points of one facet, numbered for the triangulator, and the segments between them.
class LocalFacet {
 public:
  std::vector<Index> points;  // of the mesh, by their numbers here
  std::vector<IndexPair> segments;
  std::vector<Point2> flat;
  std::vector<double> lift;

  void begin(const Outlines& outlines, Index facet) {
    points.clear();
    segments.clear();
    behind_ = is_behind(outlines, facet);
  }
  void add_segment(Index from, Index to, bool forward) {
    const Index a = number(from), b = number(to);
    segments.push_back(forward != behind_ ? IndexPair{a, b} : IndexPair{b, a});
  }
  // No segment may follow.
  void end(const Outlines& outlines, Index facet) {
    for (const auto& [_, point] : inner_of(outlines, facet)) number(point);
    for (const Index p : points) number_[p] = -1;
  }
  Projection project(Points positions, Vec3 normal) {
    const Projection projection(normal, positions[*std::min_element(points.begin(), points.end())]);
    flat.clear();
    lift.clear();
    for (const Index p : points) {
      flat.push_back(projection(positions[p]));
      lift.push_back(projection.lift(positions[p]));
    }
    return projection;
  }
  // A triangle of numbers as one of the mesh, with the facet's own winding.
  Face to_mesh(const Face& t) const { return wind({points[t[0]], points[t[1]], points[t[2]]}); }
  Face wind(const Face& t) const { return behind_ ? Face{t[0], t[2], t[1]} : t; }

 private:
  Index number(Index point) {
    if (point >= std::ssize(number_)) number_.resize(point + 1, -1);
    Index& own = number_[point];
    if (own < 0) {
      own = static_cast<Index>(points.size());
      points.push_back(point);
    }
    return own;
  }

  Array<Index> number_;  // of each point of the mesh, -1 for none
  bool behind_ = false;
};

// Directed edges that none runs against, sorted.
inline std::vector<Edge> find_unopposed(std::vector<Edge> there) {
  std::vector<Edge> back(there), only;
  for (auto& edge : back) std::swap(edge[0], edge[1]);
  std::sort(there.begin(), there.end());
  std::sort(back.begin(), back.end());
  std::set_difference(there.begin(), there.end(), back.begin(), back.end(), std::back_inserter(only));
  return only;
}

}  // namespace bldsimp
