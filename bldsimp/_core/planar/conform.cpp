#include "planar/conform.hpp"

#include <limits>
#include <tuple>

#include "planar/facet_chains.hpp"
#include "planar/projection.hpp"

namespace bldsimp {
namespace {

Edge sort_ends(Index a, Index b) { return a < b ? Edge{a, b} : Edge{b, a}; }

// The straight pieces between facets, each once, and the points at which it was cut.
class CutEdges {
 public:
  CutEdges(Points points, std::span<const Piece> pieces)
      : points_(points.begin(), points.end()), acute_(points.size(), 0) {
    for (const Piece& piece : pieces) edges_.push_back(sort_ends(piece.from, piece.to));
    sort_unique(edges_);
    cuts_.resize(edges_.size());
  }

  std::size_t size() const { return edges_.size(); }
  const Edge& ends(Index edge) const { return edges_[edge]; }
  // From the lower to the upper end.
  Indices cuts(Index edge) const { return cuts_[edge]; }
  const std::vector<Vec3>& points() const { return points_; }

  // -1 where no piece runs between a and b.
  Index find(Index a, Index b) const {
    const Edge wanted = sort_ends(a, b);
    const auto at = std::lower_bound(edges_.begin(), edges_.end(), wanted);
    return at != edges_.end() && *at == wanted ? static_cast<Index>(at - edges_.begin()) : -1;
  }

  void mark_acute(Index point) { acute_[point] = 1; }

  // End k of the parts that an edge is cut into.
  Index end(Index edge, Index k) const {
    const auto& cuts = cuts_[edge];
    return k == 0 ? edges_[edge][0] : k <= std::ssize(cuts) ? cuts[k - 1] : edges_[edge][1];
  }

  // Cuts the part between ends k and k + 1. False where rounding leaves no point between them.
  bool cut(Index edge, Index k) {
    const Vec3 a = points_[end(edge, k)], b = points_[end(edge, k + 1)];
    const Vec3 point =
        point_between(a, b, k == 0 && acute_[edges_[edge][0]], k == std::ssize(cuts_[edge]) && acute_[edges_[edge][1]]);
    if (point == a || point == b) return false;
    cuts_[edge].insert(cuts_[edge].begin() + k, static_cast<Index>(points_.size()));
    points_.push_back(point);
    return true;
  }

  // What the edges were cut into, lower end first, sorted.
  std::vector<Edge> parts() const {
    std::vector<Edge> all;
    for (Index edge = 0; edge < std::ssize(edges_); ++edge)
      for (Index k = 0; k <= std::ssize(cuts_[edge]); ++k) {
        all.push_back(sort_ends(end(edge, k), end(edge, k + 1)));
      }
    std::sort(all.begin(), all.end());
    return all;
  }

 private:
  static Vec3 point_between(Vec3 a, Vec3 b, bool acute_a, bool acute_b) {
    const double run = length(b - a);
    const bool measurable = run > 0 && run <= std::numeric_limits<double>::max();
    if (acute_a == acute_b || !measurable) return 0.5 * a + 0.5 * b;
    const double share = power_of_two_near(0.5 * run) / run;
    return acute_a ? a + share * (b - a) : b + share * (a - b);
  }

  static double power_of_two_near(double x) {
    int exponent = 0;
    const double mantissa = std::frexp(x, &exponent);
    return std::ldexp(1.0, mantissa < 0.75 ? exponent - 1 : exponent);
  }

  std::vector<Vec3> points_;
  std::vector<std::uint8_t> acute_;  // per given point
  std::vector<Edge> edges_;          // sorted
  std::vector<std::vector<Index>> cuts_;
};

// A triangle whose sides may be cut, in triangles: those at the side with the first edge look to the
// corner opposite; what is left at the other two looks to the cut next to it.
class Subdivision {
 public:
  explicit Subdivision(const CutEdges& edges) : edges_(edges) {}

  void subdivide(const Face& triangle, std::vector<Face>& out) {
    Index first = -1;
    int turn = 0;
    for (int i = 0; i < 3; ++i) {
      const Index edge = edges_.find(triangle[i], triangle[(i + 1) % 3]);
      if (edge < 0 || edges_.cuts(edge).empty() || (first >= 0 && first < edge)) continue;
      first = edge;
      turn = i;
    }
    if (first < 0) {
      out.push_back(triangle);
      return;
    }
    const Index a = triangle[turn], b = triangle[(turn + 1) % 3], c = triangle[(turn + 2) % 3];
    lay_side(a, b);
    const std::vector<Index> side(side_);
    for (std::size_t i = 1; i + 2 < side.size(); ++i) out.push_back({side[i], side[i + 1], c});
    fan(c, a, side[1], out);
    fan(b, c, side[side.size() - 2], out);
  }

 private:
  void lay_side(Index a, Index b) {
    side_.assign(1, a);
    const Index edge = edges_.find(a, b);
    if (edge >= 0) {
      const auto cuts = edges_.cuts(edge);
      append(side_, cuts);
      if (a > b) std::reverse(side_.begin() + 1, side_.end());
    }
    side_.push_back(b);
  }

  void fan(Index a, Index b, Index apex, std::vector<Face>& out) {
    lay_side(a, b);
    for (std::size_t i = 0; i + 1 < side_.size(); ++i) out.push_back({side_[i], side_[i + 1], apex});
  }

  const CutEdges& edges_;
  std::vector<Index> side_;
};

class Conformer {
 public:
  explicit Conformer(const ConformParts& parts)
      : parts_(parts), edges_(parts.points, parts.pieces), facets_(parts.planes.size()), how_(facets_), patch_(facets_),
        own_points_(facets_, 0) {
    collect_sides();
    collect_given();
    for (Index facet = 0; facet < count(); ++facet) {
      if (!may_change(facet)) how_[facet] = Conformity::kept;
      if (how_[facet] == Conformity::delaunay) mark_acute_corners(facet);
    }
  }

  ConformResult run() {
    std::vector<Index> dirty;
    for (Index facet = 0; facet < count(); ++facet)
      if (how_[facet] == Conformity::delaunay) dirty.push_back(facet);
    while (!dirty.empty()) {
      for (const Index facet : dirty) triangulate(facet);
      dirty = cut();
    }
    cut_given();
    settle();
    return result();
  }

 private:
  struct PieceSide {
    Index edge;
    bool forward;  // the facet is on the left of the way from the lower to the upper end
  };
  struct WantedCut {
    Index edge, part, facet;
    friend auto operator<=>(const WantedCut&, const WantedCut&) = default;
  };

  Index count() const { return static_cast<Index>(facets_); }
  std::span<const PieceSide> sides_of(Index facet) const {
    return {sides_.data() + side_start_[facet], sides_.data() + side_start_[facet + 1]};
  }
  Faces given_of(Index facet) const {
    return {given_.data() + given_start_[facet], given_.data() + given_start_[facet + 1]};
  }

  void collect_sides() {
    const FacetChains chains(parts_.outlines, parts_.pieces, facets_);
    facets_along_.resize(edges_.size());
    side_start_.push_back(0);
    for (Index facet = 0; facet < count(); ++facet) {
      chains.for_pieces(facet, [&](Index i, bool forward) {
        const Piece& piece = parts_.pieces[i];
        const Index edge = edges_.find(piece.from, piece.to);
        sides_.push_back({edge, forward == (piece.from < piece.to)});
        facets_along_[edge].push_back(facet);
      });
      side_start_.push_back(static_cast<Index>(sides_.size()));
    }
  }

  // The improved method's triangles by facet.
  void collect_given() {
    const Groups groups(facets_, parts_.triangles.size(), [&](Index t) { return parts_.facet_of_triangle[t]; });
    for (const Index t : groups.members) given_.push_back(parts_.triangles[t]);
    given_start_.assign(groups.start.begin(), groups.start.end());
  }

  bool may_change(Index facet) const {
    return !parts_.keep[facet] && !sides_of(facet).empty() && !given_of(facet).empty() &&
           !(parts_.planes[front_of(parts_.outlines, facet)].normal == Vec3{0, 0, 0});
  }

  // Points where two pieces of the facet meet under less than 60 degrees.
  void mark_acute_corners(Index facet) {
    std::vector<Edge> spokes;  // {point, other end}
    for (const PieceSide& side : sides_of(facet)) {
      const auto [low, high] = edges_.ends(side.edge);
      spokes.push_back({low, high});
      spokes.push_back({high, low});
    }
    sort_unique(spokes);
    const auto same_point = [](const Edge& a, const Edge& b) { return a[0] == b[0]; };
    for_runs(spokes, same_point, [&](std::span<const Edge> own) {
      for (std::size_t i = 0; i < own.size(); ++i)
        for (std::size_t j = i + 1; j < own.size(); ++j)
          if (is_acute(own[0][0], own[i][1], own[j][1])) return edges_.mark_acute(own[0][0]);
    });
  }

  bool is_acute(Index corner, Index a, Index b) const {
    const Vec3 u = parts_.points[a] - parts_.points[corner], v = parts_.points[b] - parts_.points[corner];
    return dot(u, v) > 0.5 * length(u) * length(v);
  }

  void collect_segments(Index facet) {
    local_.begin(parts_.outlines, facet);
    part_of_segment_.clear();
    for (const auto& [edge, forward] : sides_of(facet))
      for (Index k = 0; k <= std::ssize(edges_.cuts(edge)); ++k) {
        local_.add_segment(edges_.end(edge, k), edges_.end(edge, k + 1), forward);
        part_of_segment_.push_back({edge, k});
      }
    local_.end(parts_.outlines, facet);
  }

  void triangulate(Index facet) {
    patch_[facet].clear();
    collect_segments(facet);
    if (own_points_[facet] == 0) own_points_[facet] = std::ssize(local_.points);
    local_.project(edges_.points(), parts_.planes[front_of(parts_.outlines, facet)].normal);
    TriangulateOptions options;
    options.lift = local_.lift.data();
    options.recover = options.poles = false;
    triangulator_.run(local_.flat, local_.segments, options);
    statistics_ += triangulator_.statistics();
    if (triangulator_.missing().empty()) {
      for (const Face& t : triangulator_.triangles()) patch_[facet].push_back(local_.to_mesh(t));
    } else if (std::ssize(local_.points) > most_times * own_points_[facet]) {
      how_[facet] = Conformity::stopped;
    } else if (segments_meet()) {
      how_[facet] = Conformity::crossing;
    } else {
      for (const Index s : triangulator_.missing()) {
        const auto& [edge, part] = part_of_segment_[s];
        wanted_.push_back({edge, part, facet});
      }
    }
  }

  // Whether segments cross, or have a point on them: no cut would make edges of those. Not part of the
  // method, so that its work does not count.
  bool segments_meet() {
    TriangulateOptions options;
    options.carve = false;
    if (checker_.run(local_.flat, local_.segments, options) != Status::done) return true;
    for (Index p = 0; p < std::ssize(local_.flat); ++p)
      if (checker_.point_of_input()[p] != p) return true;
    return std::any_of(checker_.pieces().begin(), checker_.pieces().end(),
                       [&](const Triangulator::SegmentPiece& piece) {
                         return std::minmax(piece.a, piece.b) !=
                                std::minmax(local_.segments[piece.segment][0], local_.segments[piece.segment][1]);
                       });
  }

  // Cuts what is wanted; returns the facets that must look again, in rising order.
  std::vector<Index> cut() {
    std::sort(wanted_.begin(), wanted_.end());
    std::vector<std::uint8_t> changed(facets_, 0);
    // From the last part of an edge to its first, so that cutting one leaves the numbers of the others.
    for (auto last = wanted_.rbegin(); last != wanted_.rend();) {
      const auto [edge, part, _] = *last;
      const bool done = edges_.cut(edge, part);
      for (; last != wanted_.rend() && last->edge == edge && last->part == part; ++last)
        if (!done) how_[last->facet] = Conformity::crossing;
      if (done)
        for (const Index facet : facets_along_[edge]) changed[facet] = 1;
    }
    wanted_.clear();
    std::vector<Index> dirty;
    for (Index facet = 0; facet < count(); ++facet)
      if (changed[facet] && how_[facet] == Conformity::delaunay) dirty.push_back(facet);
    return dirty;
  }

  // The improved method's triangles, with the cuts.
  void cut_given() {
    Subdivision subdivision(edges_);
    std::vector<Face> cut;
    std::vector<Index> start{0};
    for (Index facet = 0; facet < count(); ++facet) {
      for (const Face& triangle : given_of(facet)) subdivision.subdivide(triangle, cut);
      start.push_back(static_cast<Index>(cut.size()));
    }
    given_ = std::move(cut);
    given_start_ = std::move(start);
  }

  // Facets whose triangles do not fit take those of the improved method.
  void settle() {
    parts_of_edges_ = edges_.parts();
    for (Index facet = 0; facet < count(); ++facet) {
      const auto given = given_of(facet);
      if (how_[facet] == Conformity::delaunay && rim_of(patch_[facet]) != rim_of(given))
        how_[facet] = Conformity::crossing;
      if (how_[facet] != Conformity::delaunay) take_given(facet);
    }
    while (resolve_clashes()) {
    }
  }

  // Directed edges along parts of pieces, as often as the triangles use them, and others that have nothing
  // to run against; sorted. What is opposed need not be inside: a facet may be on both sides of a piece.
  std::vector<Edge> rim_of(Faces triangles) const {
    std::vector<Edge> along, inside;
    for (const Face& t : triangles)
      for (int i = 0; i < 3; ++i) {
        const Edge edge{t[i], t[(i + 1) % 3]};
        const bool is_part =
            std::binary_search(parts_of_edges_.begin(), parts_of_edges_.end(), sort_ends(edge[0], edge[1]));
        (is_part ? along : inside).push_back(edge);
      }
    inside = find_unopposed(std::move(inside));
    append(along, inside);
    std::sort(along.begin(), along.end());
    return along;
  }

  void take_given(Index facet) { patch_[facet].assign(given_of(facet).begin(), given_of(facet).end()); }

  // Where facets lay an inner edge on an edge of others, all that may take the improved method's triangles do. True
  // if there were any. Two sides of a sheet may share their inner edges.
  bool resolve_clashes() {
    std::vector<std::pair<Edge, Index>> now, before;
    for (Index facet = 0; facet < count(); ++facet) {
      add_edges(patch_[facet], facet, now);
      add_edges(given_of(facet), facet, before);
    }
    std::sort(now.begin(), now.end());
    std::sort(before.begin(), before.end());
    bool clashing = false;
    auto old = before.begin();
    for (auto from = now.begin(); from != now.end();) {
      auto to = from;
      while (to != now.end() && to->first == from->first) ++to;
      old = std::find_if(old, before.end(), [&](const auto& use) { return use.first >= from->first; });
      const auto old_end = std::find_if(old, before.end(), [&](const auto& use) { return use.first != from->first; });
      const bool sheet = to - from == 4 && from[0].second == from[1].second && from[2].second == from[3].second &&
                         parts_.outlines.back[from[0].second] == from[2].second;
      if (to - from > 2 && to - from > old_end - old && !sheet)
        for (auto use = from; use != to; ++use) {
          if (how_[use->second] != Conformity::delaunay) continue;
          how_[use->second] = Conformity::clash;
          take_given(use->second);
          clashing = true;
        }
      from = to;
    }
    return clashing;
  }

  static void add_edges(Faces triangles, Index facet, std::vector<std::pair<Edge, Index>>& edges) {
    for (const Face& t : triangles)
      for (int i = 0; i < 3; ++i) edges.push_back({sort_ends(t[i], t[(i + 1) % 3]), facet});
  }

  ConformResult result() {
    ConformResult result;
    result.made.assign(edges_.points().begin() + std::ssize(parts_.points), edges_.points().end());
    for (Index facet = 0; facet < count(); ++facet) {
      append(result.triangles, patch_[facet]);
      result.facet_of_triangle.insert(result.facet_of_triangle.end(), patch_[facet].size(), facet);
    }
    result.facets = std::move(how_);
    result.statistics = statistics_;
    return result;
  }

  const ConformParts& parts_;
  CutEdges edges_;
  std::size_t facets_;
  std::vector<Conformity> how_;
  std::vector<std::vector<Face>> patch_;
  std::vector<std::int64_t> own_points_;
  std::vector<PieceSide> sides_;
  std::vector<Index> side_start_;
  std::vector<std::vector<Index>> facets_along_;  // per edge
  std::vector<Face> given_;
  std::vector<Index> given_start_;
  std::vector<WantedCut> wanted_;
  std::vector<Edge> parts_of_edges_;
  Statistics statistics_;

  Triangulator triangulator_, checker_;
  LocalFacet local_;
  std::vector<std::pair<Index, Index>> part_of_segment_;  // {edge, part}
};

}  // namespace

ConformResult conform(const ConformParts& parts) { return Conformer(parts).run(); }

}  // namespace bldsimp
