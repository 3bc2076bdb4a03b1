#include "details/loop_closing.hpp"

#include <limits>

#include "details/ear_filling.hpp"
#include "details/outline_triangles.hpp"

namespace bldsimp {
namespace {

// Three planes meet in a point where their normals span at least this much.
constexpr double kLeastSpan = 0.05;

template <class Items>
void rotate_to(Items& items, std::size_t first) {
  std::rotate(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(first), items.end());
}

}  // namespace

Vec3 LoopCloser::at(Index point) const {
  for (const auto& [moved, to] : moved_)
    if (moved == point) return to;
  return graph_.points()[point];
}

// Runs of edges by the plane across, or none where the loop has an open edge.
std::vector<LoopCloser::Run> LoopCloser::find_runs(const Loop& loop) {
  std::vector<Index> planes, own;
  for (const LoopEdge& e : loop) {
    if (e.outside < 0) {
      why_ = Unclosed::open;
      return {};
    }
    const Index facet = graph_.facet_of(e.outside);
    const auto same = std::find_if(planes.begin(), planes.end(), [&](Index f) { return graph_.continues(f, facet); });
    labels_part_ |= same == planes.end() &&
                    std::any_of(planes.begin(), planes.end(), [&](Index f) { return graph_.share_plane(f, facet); });
    own.push_back(same == planes.end() ? facet : *same);
    if (same == planes.end()) planes.push_back(facet);
  }
  std::size_t first = 0;
  while (first < loop.size() && own[first] == own[(first + loop.size() - 1) % loop.size()]) ++first;
  std::vector<Run> runs;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const std::size_t i = (first + k) % loop.size();
    if (runs.empty() || runs.back().facet != own[i]) runs.push_back({own[i], {loop[i].from}});
    runs.back().points.push_back(loop[i].to);
  }
  return runs;
}

void LoopCloser::add_outline(const Run& run, bool is_ring) {
  std::vector<Index> ring = run.points;
  if (ring.front() == ring.back()) ring.pop_back();
  if (ring.size() < 3) return;
  if (!is_ring) {
    bent_.push_back({run.facet, {std::move(ring)}});
    return;
  }
  const auto same =
      std::find_if(flat_.begin(), flat_.end(), [&](const Outline& o) { return graph_.continues(o.facet, run.facet); });
  if (same != flat_.end())
    same->rings.push_back(std::move(ring));
  else
    flat_.push_back({run.facet, {std::move(ring)}});
}

// Cuts off the run with the shortest chord between two runs of one plane: the chord lies in that plane, too.
bool LoopCloser::cut_shortest(std::vector<Run>& runs) {
  double shortest = std::numeric_limits<double>::infinity();
  std::size_t best = 0;
  const std::size_t n = runs.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Run &own = runs[i], &before = runs[(i + n - 1) % n], &after = runs[(i + 1) % n];
    if (before.facet != after.facet || !on_plane(before.facet, own.points.front()) ||
        !on_plane(before.facet, own.points.back()))
      continue;
    const double chord = length(at(own.points.front()) - at(own.points.back()));
    if (chord < shortest) shortest = chord, best = i;
  }
  if (shortest == std::numeric_limits<double>::infinity()) return false;
  rotate_to(runs, (best + n - 1) % n);
  add_outline(runs[1], false);
  append(runs[0].points, runs[2].points);
  runs.erase(runs.begin() + 1, runs.begin() + 3);
  return true;
}

bool LoopCloser::close_two(std::vector<Run>& runs) {
  const Index p = runs[0].points.front(), q = runs[0].points.back();
  if (p == q || !on_plane(runs[0].facet, p) || !on_plane(runs[1].facet, p) || !on_plane(runs[0].facet, q) ||
      !on_plane(runs[1].facet, q))
    return false;
  for (const Run& run : runs) add_outline(run, false);
  return true;
}

// Three planes meet in a point, which the point that is free moves to.
bool LoopCloser::close_three(std::vector<Run>& runs) {
  std::array<Vec3, 3> n;
  for (std::size_t i = 0; i < 3; ++i) {
    n[i] = graph_.shape(runs[i].facet).normal;
    if (!on_plane(runs[(i + 2) % 3].facet, runs[i].points.front())) return false;
  }
  const double span = dot(n[0], cross(n[1], n[2]));
  if (std::abs(span) < kLeastSpan) return false;
  Vec3 corner{0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i)
    corner = corner + (graph_.shape(runs[i].facet).offset / span) * cross(n[(i + 1) % 3], n[(i + 2) % 3]);
  Index there = -1;
  for (const Run& run : runs)
    for (const Index p : run.points)
      if (length(at(p) - corner) <= 4 * graph_.flat()) there = p;
  if (there < 0) {
    if (free_point_ < 0) return false;
    there = std::exchange(free_point_, -1);
    moved_.push_back({there, corner});
  }
  for (Run& run : runs) {
    if (run.points.front() != there && run.points.back() != there) run.points.push_back(there);
    add_outline(run, false);
  }
  return true;
}

// Takes a loop apart into outlines, each in one plane of the facets around it; or leaves all as it was.
bool LoopCloser::reduce(const Loop& loop) {
  const auto flat = flat_, bent = bent_;
  const auto moved = moved_.size();
  const Index free_point = free_point_;
  if (take_apart(loop)) return true;
  flat_ = flat, bent_ = bent, free_point_ = free_point;
  moved_.resize(moved);
  return false;
}

bool LoopCloser::take_apart(const Loop& loop) {
  labels_part_ = false;
  std::vector<Run> runs = find_runs(loop);
  if (runs.empty()) return false;
  if (runs.size() == 1) {
    add_outline(runs[0], true);
    return true;
  }
  while (runs.size() > 1) {
    if (runs.size() == 2) return close_two(runs) || refuse_plane();
    if (cut_shortest(runs)) continue;
    return (runs.size() == 3 && close_three(runs)) || refuse_plane();
  }
  add_outline(runs[0], false);
  return true;
}

bool LoopCloser::can_close(const Loop& loop) {
  flat_.clear(), bent_.clear(), moved_.clear();
  free_point_ = -1;
  if (!reduce(loop)) return false;
  return flat_.empty() || graph_.twice_area(loop, graph_.shape(flat_[0].facet).normal) > graph_.flat() * graph_.flat();
}

// Where a point comes to lie in a plane if it stays in those of the facets at it that stay.
std::optional<Vec3> LoopCloser::slide_point(Index point, Indices facets, Index plane, double reach) const {
  std::vector<Index> around;
  for (const Index f : graph_.faces_at(point)) {
    const Index facet = graph_.facet_of(f);
    if (std::binary_search(facets.begin(), facets.end(), facet)) continue;
    if (std::none_of(around.begin(), around.end(), [&](Index g) { return graph_.share_plane(g, facet); }))
      around.push_back(facet);
  }
  if (around.empty() || around.size() > 2) return {};
  const Vec3 n = graph_.shape(plane).normal, a = graph_.shape(around[0]).normal;
  const Vec3 way = around.size() == 1 ? n - dot(n, a) * a : normalize(cross(a, graph_.shape(around[1]).normal));
  const double rise = dot(n, way), height = graph_.height_over(plane, at(point));
  if (std::abs(rise) < 0.5 || std::abs(height) > reach) return {};
  return at(point) - (height / rise) * way;
}

// Moves a loop into a plane, where it becomes a ring of the cap there.
bool LoopCloser::slide(const Loop& loop, Indices facets, Index plane, double reach) {
  for (const LoopEdge& e : loop) {
    if (e.outside < 0) return refuse(Unclosed::open);
    const auto to = slide_point(e.from, facets, plane, reach);
    if (!to) return refuse(Unclosed::plane);
    moved_.push_back({e.from, *to});
  }
  Run run{plane, {}};
  for (const LoopEdge& e : loop) run.points.push_back(e.from);
  run.points.push_back(loop[0].from);
  add_outline(run, true);
  return true;
}

bool LoopCloser::triangulate(Outline& outline, Caps& caps) {
  std::vector<Index> ids;
  std::vector<Edge> edges;
  for (const auto& ring : outline.rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) edges.push_back({ring[i], ring[(i + 1) % ring.size()]});
    append(ids, ring);
  }
  std::vector<Index> points = ids;
  sort_unique(points);
  if (points.size() < ids.size()) return refuse(Unclosed::outline);
  std::vector<Vec3> places;
  for (const Index p : points) places.push_back(at(p));
  const FacetShape& plane = graph_.shape(outline.facet);
  const auto faces =
      triangulate_outline(triangulator_, plane.normal, edges, points, places, graph_.flat() * plane.radius);
  if (!faces) return refuse(Unclosed::outline);
  append(caps.faces, *faces);
  caps.parent.resize(caps.faces.size(), graph_.faces_of(outline.facet)[0]);
  return true;
}

// Whether the caps run along each edge of the loops as what goes did, and share no other edge with what stays.
bool LoopCloser::fits(const std::vector<Loop>& loops, Indices facets, const Caps& caps) {
  std::vector<std::pair<Index, Index>> made, wanted;
  for (const Face& f : caps.faces)
    for (std::size_t i = 0; i < 3; ++i) made.push_back({f[i], f[(i + 1) % 3]});
  for (const Loop& loop : loops)
    for (const LoopEdge& e : loop)
      if (e.outside >= 0) wanted.push_back({e.from, e.to});
  std::sort(made.begin(), made.end());
  std::sort(wanted.begin(), wanted.end());
  const auto has = [](const auto& edges, Index a, Index b) {
    return std::binary_search(edges.begin(), edges.end(), std::pair(a, b));
  };
  if (std::adjacent_find(made.begin(), made.end()) != made.end() ||
      !std::includes(made.begin(), made.end(), wanted.begin(), wanted.end()))
    return refuse(Unclosed::outline);
  for (const auto& [a, b] : made) {
    if (has(wanted, a, b)) continue;
    if (!has(made, b, a)) return refuse(Unclosed::outline);
    for (const Index f : graph_.faces_at(a)) {
      const bool goes = std::binary_search(facets.begin(), facets.end(), graph_.facet_of(f));
      if (!goes && has_corner(graph_.faces()[f], b)) return refuse(Unclosed::edge);
    }
  }
  return true;
}

std::optional<Caps> LoopCloser::close(const std::vector<Loop>& loops, Indices facets, double reach) {
  flat_.clear(), bent_.clear(), moved_.clear();
  std::vector<Index> used;
  for (const Loop& loop : loops)
    for (const LoopEdge& e : loop) used.push_back(e.from);
  sort_unique(used);
  free_point_ = -1;
  for (const Index k : facets)
    for (const Index f : graph_.faces_of(k))
      for (const Index p : graph_.faces()[f])
        if (!std::binary_search(used.begin(), used.end(), p) && (free_point_ < 0 || p < free_point_) &&
            std::all_of(graph_.faces_at(p).begin(), graph_.faces_at(p).end(),
                        [&](Index g) { return std::binary_search(facets.begin(), facets.end(), graph_.facet_of(g)); }))
          free_point_ = p;
  std::vector<const Loop*> sliding;
  for (const Loop& loop : loops) {
    if (std::all_of(loop.begin(), loop.end(), [](const LoopEdge& e) { return e.outside < 0; })) continue;
    if (!reduce(loop)) sliding.push_back(&loop);
  }
  // What cannot be closed may slide into the plane of a loop that can.
  if (!sliding.empty() && (reach == 0 || flat_.size() != 1)) return {};
  for (const Loop* loop : sliding)
    if (!slide(*loop, facets, flat_[0].facet, reach)) return {};
  Caps caps;
  for (auto* outlines : {&flat_, &bent_})
    for (Outline& outline : *outlines)
      if (!triangulate(outline, caps)) return {};
  if (!fits(loops, facets, caps)) return {};
  caps.moved = moved_;
  return caps;
}

std::optional<Caps> LoopCloser::close_open(const Loop& loop) {
  // Edges without a twin may have more than one face all the same.
  const auto is_open = [&](const LoopEdge& e) {
    const Indices star = graph_.faces_at(e.from);
    return std::count_if(star.begin(), star.end(), [&](Index f) { return has_corner(graph_.faces()[f], e.to); }) == 1;
  };
  const Index label = graph_.shape(graph_.facet_of(loop[0].outside)).label;
  const auto has_label = [&](const LoopEdge& e) { return graph_.shape(graph_.facet_of(e.outside)).label == label; };
  if (!std::all_of(loop.begin(), loop.end(), is_open)) {
    why_ = Unclosed::edge;
    return {};
  }
  if (!std::all_of(loop.begin(), loop.end(), has_label)) {
    why_ = Unclosed::label;
    return {};
  }
  if (auto caps = close({loop}, {}, 0)) return caps;
  auto faces = fill_loop(graph_, loop);
  if (!faces) return {};
  Caps caps{std::move(*faces), {}, {}};
  caps.parent.assign(caps.faces.size(), loop[0].outside);
  if (!fits({loop}, {}, caps)) return {};
  return caps;
}

}  // namespace bldsimp
