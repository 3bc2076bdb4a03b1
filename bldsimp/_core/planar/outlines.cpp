#include "planar/outlines.hpp"

#include "mesh/edges.hpp"
#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

class Tracer {
 public:
  Tracer(Faces faces, Index point_count, const Halfedges& halfedges, Indices facet_of_face, Flags frozen)
      : faces_(faces), points_(point_count), halfedges_(halfedges), facet_(facet_of_face), frozen_(frozen) {}

  Outlines trace() {
    find_backs();
    mark_outline_edges();
    collect_edges();
    find_chain_ends();
    walk_chains();
    return std::move(outlines_);
  }

 private:
  enum Flag : std::uint8_t { outline = 1, grouped = 2, within_facets = 4 };

  Index origin(Index h) const { return bldsimp::origin(faces_, h); }
  Index end(Index h) const { return target(faces_, h); }
  Index facet(Index h) const { return facet_[h / 3]; }

  bool inside_facet(Index h) const {
    const Index t = halfedges_.twin[h];
    return t >= 0 && facet(h) == facet(t) && !frozen_[facet(h)];
  }

  // The face with the same points the other way round stands next to a face in the order of `weld`.
  Index back_of_face(Index f) const {
    for (const Index g : {f - 1, f + 1})
      if (g >= 0 && g < static_cast<Index>(faces_.size()) && faces_[g][0] == faces_[f][0] &&
          faces_[g][1] == faces_[f][2] && faces_[g][2] == faces_[f][1])
        return g;
    return -1;
  }

  void find_backs() {
    constexpr Index unknown = -2;
    auto& back = outlines_.back;
    back.assign(frozen_.size(), unknown);
    for (Index f = 0; f < static_cast<Index>(faces_.size()); ++f) {
      Index& known = back[facet_[f]];
      if (known == -1) continue;
      const Index g = back_of_face(f);
      const Index facet = g < 0 ? -1 : facet_[g];
      known = known == unknown || known == facet ? facet : -1;
    }
    for (std::size_t f = 0; f < back.size(); ++f)
      if (back[f] >= 0 && back[back[f]] != static_cast<Index>(f)) back[f] = -1;
  }

  // An edge that more than two faces share is a chain, so that the sheets that meet there do not come
  // apart, unless these are the two sides of one sheet.
  void mark_outline_edges() {
    flags_.resize(halfedges_.twin.size());
    parallel_each(flags_.size(), [&](Index h) { flags_[h] = inside_facet(h) ? 0 : outline; });
    halfedges_.for_groups([&](Indices group) {
      const bool inside = std::all_of(group.begin(), group.end(), [&](Index h) {
        return flags_[h] == 0 && outlines_.back[facet(h)] >= 0 &&
               (facet(h) == facet(group[0]) || facet(h) == outlines_.back[facet(group[0])]);
      });
      const bool bounds_none = std::none_of(group.begin(), group.end(), [&](Index h) { return flags_[h] & outline; });
      const int flags = inside ? grouped : bounds_none ? grouped | outline | within_facets : grouped | outline;
      for (const Index h : group) flags_[h] = static_cast<std::uint8_t>(flags);
    });
  }

  // Each outline edge once, from its lower to its upper end, with its uses.
  void collect_edges() {
    const auto add_edge = [&](Indices members) {
      const Index h = members[0];
      edges_.push_back({std::min(origin(h), end(h)), std::max(origin(h), end(h))});
      for (const Index m : members) edge_uses_.push_back({facet(m), origin(m) < end(m)});
      std::sort(edge_uses_.begin() + edge_use_start_.back(), edge_uses_.end());
      edge_use_start_.push_back(static_cast<Index>(edge_uses_.size()));
      edge_within_facets_.push_back((flags_[h] & within_facets) != 0);
    };
    for (Index h = 0; h < static_cast<Index>(flags_.size()); ++h) {
      if (flags_[h] != outline) continue;
      const Index t = halfedges_.twin[h];
      const IndexPair members{h, t};
      if (t < 0 || h < t) add_edge(std::span(members.data(), t < 0 ? 1 : 2));
    }
    halfedges_.for_groups([&](Indices group) {
      if (flags_[group[0]] & outline) add_edge(group);
    });
    edges_at_ = Groups(points_, 2 * edges_.size(), [&](Index end) { return edges_[end / 2][end % 2]; });
    for (Index& e : edges_at_.members) e /= 2;
  }

  Indices edges_at(Index p) const { return edges_at_[p]; }
  std::span<const FacetUse> uses_of(Index e) const {
    return {edge_uses_.data() + edge_use_start_[e], edge_uses_.data() + edge_use_start_[e + 1]};
  }

  // Whether a chain may run through p: two edges, and each facet that comes in along one leaves along
  // the other.
  bool runs_through(Index p) const { return runs_through(p, edges_at(p)); }

  bool runs_through(Index p, Indices at) const {
    if (at.size() != 2) return false;
    const auto a = uses_of(at[0]), b = uses_of(at[1]);
    const bool first_ends_here = edges_[at[0]][1] == p, second_ends_here = edges_[at[1]][1] == p;
    if (a.size() != b.size()) return false;
    if (first_ends_here != second_ends_here) return std::equal(a.begin(), a.end(), b.begin());
    std::vector<FacetUse> turned(b.begin(), b.end());
    for (FacetUse& use : turned) use.forward = !use.forward;
    std::sort(turned.begin(), turned.end());
    return std::equal(a.begin(), a.end(), turned.begin());
  }

  // Counts the corners of faces in each fan. A fan that no outline bounds closes round its point; a
  // point that has one beside other fans is where sheets touch, and stays.
  void find_chain_ends() {
    outlines_.is_chain_end.assign(points_, 0);
    for (Index p = 0; p < points_; ++p)
      if (!edges_at(p).empty() && !runs_through(p)) outlines_.is_chain_end[p] = 1;

    find_touching();
    keep_touching_points();
    count_touching_points();
  }

  // What its fans between outlines leave of a point's corners belongs to closed fans: a single one, alone, may
  // go. Inside a two-sided sheet all edges are shared: there the point may go from both sides.
  void find_touching() {
    struct FanCount {
      Index left = 0;
      Index inner = -1;  // a halfedge from the point that is no outline
    };
    Array<FanCount> corners(points_, FanCount{});
    Index h = 0;
    for (const Face& face : faces_)
      for (const Index p : face) {
        ++corners[p].left;
        if (flags_[h] & outline)
          corners[p].left -= fan_size(h);
        else
          corners[p].inner = h;
        ++h;
      }
    touches_.assign(points_, 0);
    parallel_each(points_, [&](Index p) {
      const auto [left, inner] = corners[p];
      if (left != 0) touches_[p] = !edges_at(p).empty() || (fan_size(inner) != left && !all_grouped(inner));
    });
  }

  // Number of corners met when turning from h round its origin until an outline, or h again.
  Index fan_size(Index h) const {
    Index size = 0;
    Index at = h;
    do {
      ++size;
      const Index back = previous_halfedge(at);
      if (flags_[back] & outline) break;
      at = halfedges_.twin[back];
    } while (at != h);
    return size;
  }

  bool all_grouped(Index h) const {
    Index at = h;
    do {
      if (!(flags_[at] & grouped)) return false;
      at = halfedges_.twin[previous_halfedge(at)];
    } while (at != h);
    return true;
  }

  void keep_touching_points() {
    if (std::find(touches_.begin(), touches_.end(), 1) == touches_.end()) return;
    auto& inner = outlines_.inner;
    for (Index h = 0; h < static_cast<Index>(flags_.size()); ++h) {
      if (!touches_[origin(h)]) continue;
      outlines_.is_chain_end[origin(h)] = 1;
      inner.push_back({facet(h), origin(h)});
    }
    sort_unique(inner);
  }

  // Chain ends that would be none if no sheets met inside of facets.
  void count_touching_points() {
    std::vector<Index> borders;
    for (Index p = 0; p < points_; ++p) {
      if (!outlines_.is_chain_end[p]) continue;
      borders.clear();
      for (const Index e : edges_at(p))
        if (!edge_within_facets_[e]) borders.push_back(e);
      outlines_.touching += borders.empty() || runs_through(p, borders);
    }
  }

  void walk_chains() {
    walked_.assign(edges_.size(), 0);
    for (Index p = 0; p < points_; ++p)
      if (outlines_.is_chain_end[p])
        for (const Index e : edges_at(p))
          if (!walked_[e]) walk_from(p, e);
    // What is left are closed chains without ends; their least point comes first, and the first of
    // its edges leads to its lower neighbor.
    for (Index p = 0; p < points_; ++p) {
      const auto at = edges_at(p);
      if (at.empty() || walked_[at[0]]) continue;
      const auto other = [&](Index e) { return edges_[e][0] == p ? edges_[e][1] : edges_[e][0]; };
      walk_from(p, other(at[0]) < other(at[1]) ? at[0] : at[1]);
    }
  }

  void walk_from(Index p, Index e) {
    auto& points = outlines_.chain_points;
    const Index first_edge = e, first = p;
    points.push_back(p);
    for (;;) {
      walked_[e] = 1;
      p = edges_[e][0] == p ? edges_[e][1] : edges_[e][0];
      points.push_back(p);
      if (p == first || outlines_.is_chain_end[p]) break;
      const auto at = edges_at(p);
      e = at[0] == e ? at[1] : at[0];
    }
    const auto chain = points.begin() + outlines_.chain_start.back();
    const bool closed = p == first;
    const bool turn = closed ? points[points.size() - 2] < *(chain + 1) : p < first;
    bool along = (edges_[first_edge][0] == first) != turn;
    if (turn) std::reverse(chain, points.end());
    outlines_.chain_start.push_back(static_cast<Index>(points.size()));
    for (const FacetUse& use : uses_of(first_edge)) outlines_.uses.push_back({use.facet, use.forward == along});
    std::sort(outlines_.uses.begin() + outlines_.use_start.back(), outlines_.uses.end());
    outlines_.use_start.push_back(static_cast<Index>(outlines_.uses.size()));
  }

  Faces faces_;
  Index points_;
  const Halfedges& halfedges_;
  Indices facet_;
  Flags frozen_;
  Outlines outlines_;
  Array<std::uint8_t> flags_;  // per halfedge
  std::vector<Edge> edges_;
  std::vector<Index> edge_use_start_{0};
  std::vector<FacetUse> edge_uses_;
  std::vector<std::uint8_t> edge_within_facets_;  // shared by sheets, but no facet ends there
  Groups edges_at_;                               // per point
  Array<std::uint8_t> touches_;                   // per point: sheets touch there
  std::vector<std::uint8_t> walked_;
};

}  // namespace

Outlines trace_outlines(Faces faces, Index point_count, const Halfedges& halfedges, const Facets& facets,
                        Flags frozen) {
  return Tracer(faces, point_count, halfedges, facets.facet_of_face, frozen).trace();
}

}  // namespace bldsimp
