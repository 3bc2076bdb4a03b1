#include "details/facet_slide.hpp"

#include <map>

#include "details/outline_triangles.hpp"

namespace bldsimp {
namespace {

// A point may not go far along planes that are nearly square to its way.
constexpr double kLeastRise = 0.5;
constexpr std::size_t kMostFaces = 2000;

class FacetSlider {
 public:
  FacetSlider(const FacetGraph& graph, Triangulator& triangulator, Index facet, Index plane, double reach)
      : graph_(graph), triangulator_(triangulator), facet_(facet), plane_(plane), reach_(reach) {}

  std::optional<FacetSlide> run() {
    if (!find_places() || !find_outlines() || !rebuild() || !is_sound()) return {};
    return std::move(slide_);
  }

 private:
  bool find_places() {
    for (const Index f : graph_.faces_of(facet_))
      for (const Index p : graph_.faces()[f]) {
        if (target_.contains(p)) continue;
        const auto to = find_place(p);
        if (!to) return false;
        Index at = -1;
        for (const Index g : graph_.faces_at(p))
          for (const Index q : graph_.faces()[g])
            if (q != p && length(graph_.points()[q] - *to) <= 4 * graph_.flat()) at = q;
        target_[p] = at;
        if (at < 0) slide_.caps.moved.push_back({p, *to});
      }
    // What others come to must stay.
    return std::none_of(target_.begin(), target_.end(),
                        [&](const auto& one) { return one.second >= 0 && target_.contains(one.second); });
  }

  std::optional<Vec3> find_place(Index point) const {
    std::vector<Index> around;
    for (const Index f : graph_.faces_at(point)) {
      const Index other = graph_.facet_of(f);
      const auto parallel = [&](Index g) {
        return std::abs(dot(graph_.shape(g).normal, graph_.shape(other).normal)) > parallel_facets;
      };
      if (!parallel(facet_) && std::none_of(around.begin(), around.end(), parallel)) around.push_back(other);
    }
    const Vec3 n = graph_.shape(plane_).normal, p = graph_.points()[point];
    Vec3 way = n;
    if (around.size() == 1) {
      const Vec3 a = graph_.shape(around[0]).normal;
      way = n - dot(n, a) * a;
    } else if (around.size() > 1) {
      way = normalize(cross(graph_.shape(around[0]).normal, graph_.shape(around[1]).normal));
      for (std::size_t i = 2; i < around.size(); ++i)
        if (std::abs(dot(way, graph_.shape(around[i]).normal)) * reach_ > 4 * graph_.flat()) return {};
    }
    const double rise = dot(n, way), height = graph_.height_over(plane_, p);
    if (std::abs(rise) < kLeastRise * length(way)) return {};
    const Vec3 to = p - (height / rise) * way;
    if (length(to - p) > reach_) return {};
    return to;
  }

  Index map(Index p) const {
    const auto found = target_.find(p);
    return found == target_.end() || found->second < 0 ? p : found->second;
  }

  Vec3 place(Index p) const {
    for (const auto& [moved, to] : slide_.caps.moved)
      if (moved == p) return to;
    return graph_.points()[p];
  }

  // The outlines of all facets at points that move, as they will be, split at points that come to lie on an edge.
  bool find_outlines() {
    for (const auto& [p, at] : target_)
      for (const Index f : graph_.faces_at(p)) outlines_[graph_.facet_of(f)];
    std::size_t faces = 0;
    std::vector<Index> points;
    for (auto& [facet, edges] : outlines_) {
      faces += graph_.faces_of(facet).size();
      if (faces > kMostFaces) return false;
      for (const Loop& loop : graph_.find_loops(std::array{facet}))
        for (const LoopEdge& e : loop) {
          const Index a = map(e.from), b = map(e.to);
          points.push_back(a);
          if (a != b) edges.push_back({a, b});
        }
    }
    sort_unique(points);
    for (auto& [facet, edges] : outlines_) {
      std::vector<Edge> split;
      for (const Edge& edge : edges) split_edge(edge, points, split);
      edges = cancel(std::move(split));
    }
    return true;
  }

  void split_edge(const Edge& edge, const std::vector<Index>& points, std::vector<Edge>& split) const {
    const Vec3 from = place(edge[0]), way = place(edge[1]) - from;
    std::vector<std::pair<double, Index>> inside;
    if (has_moved(edge))
      for (const Index p : points) {
        const Vec3 at = place(p);
        const double share = dot(at - from, way) / dot(way, way);
        if (p == edge[0] || p == edge[1] || share <= 0 || share >= 1) continue;
        if (length(at - from - share * way) <= 4 * graph_.flat()) inside.push_back({share, p});
      }
    std::sort(inside.begin(), inside.end());
    Index last = edge[0];
    for (const auto& [share, p] : inside) {
      split.push_back({last, p});
      last = p;
    }
    split.push_back({last, edge[1]});
  }

  // Whether an edge is not where it was.
  bool has_moved(const Edge& edge) const {
    return std::any_of(target_.begin(), target_.end(), [&](const auto& one) {
      const Index at = one.second < 0 ? one.first : one.second;
      return at == edge[0] || at == edge[1];
    });
  }

  static std::vector<Edge> cancel(std::vector<Edge> edges) {
    std::vector<Edge> left;
    std::sort(edges.begin(), edges.end());
    for_runs(
        edges, [](const Edge& e, const Edge& f) { return e == f; },
        [&](auto same) {
          const auto [from, to] = std::equal_range(edges.begin(), edges.end(), Edge{same[0][1], same[0][0]});
          const auto most = std::ssize(same) - (to - from);
          for (std::ptrdiff_t i = 0; i < most; ++i) left.push_back(same[0]);
        });
    return left;
  }

  bool rebuild() {
    for (auto& [facet, edges] : outlines_) {
      append(slide_.gone, graph_.faces_of(facet));
      if (edges.empty()) continue;
      std::vector<Index> points;
      for (const Edge& e : edges) append(points, e);
      sort_unique(points);
      std::vector<Vec3> places;
      for (const Index p : points) places.push_back(place(p));
      const Vec3 normal = graph_.shape(facet == facet_ ? plane_ : facet).normal;
      const auto faces =
          triangulate_outline(triangulator_, normal, edges, points, places, graph_.flat() * graph_.shape(facet).radius);
      if (!faces) return false;
      append(slide_.caps.faces, *faces);
      slide_.caps.parent.resize(slide_.caps.faces.size(), graph_.faces_of(facet)[0]);
    }
    std::sort(slide_.gone.begin(), slide_.gone.end());
    return slide_.caps.faces.size() < slide_.gone.size();
  }

  // Whether each edge is used by as many faces each way, and by no more than two or than were there.
  bool is_sound() const {
    std::map<IndexPair, std::array<Index, 2>> uses;
    const auto count = [&](const Face& f, Index sign) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Index a = f[i], b = f[(i + 1) % 3];
        auto& [way, all] = uses[{std::min(a, b), std::max(a, b)}];
        way += a < b ? sign : -sign;
        all += sign > 0;
      }
    };
    for (const Face& f : slide_.caps.faces) count(f, 1);
    // What goes, at the places that its points come to.
    for (const Index f : slide_.gone) {
      const auto [a, b, c] = graph_.faces()[f];
      const Face face{map(a), map(b), map(c)};
      if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) count(face, -1);
    }
    return std::all_of(uses.begin(), uses.end(), [&](const auto& one) {
      return one.second[0] == 0 && one.second[1] + count_uses(one.first) <= std::max(Index{2}, count_before(one.first));
    });
  }

  // Staying faces at an edge.
  Index count_uses(const IndexPair& edge) const {
    const Indices star = graph_.faces_at(edge[0]);
    return static_cast<Index>(std::count_if(star.begin(), star.end(), [&](Index f) {
      return has_corner(graph_.faces()[f], edge[1]) && !std::binary_search(slide_.gone.begin(), slide_.gone.end(), f);
    }));
  }
  Index count_before(const IndexPair& edge) const {
    const Indices star = graph_.faces_at(edge[0]);
    return static_cast<Index>(
        std::count_if(star.begin(), star.end(), [&](Index f) { return has_corner(graph_.faces()[f], edge[1]); }));
  }

  const FacetGraph& graph_;
  Triangulator& triangulator_;
  Index facet_, plane_;
  double reach_;
  std::map<Index, Index> target_;  // of each point: the neighbor that it comes to, or -1
  std::map<Index, std::vector<Edge>> outlines_;
  FacetSlide slide_;
};

}  // namespace

std::vector<Index> find_slide_planes(const FacetGraph& graph, Index facet, double reach) {
  const FacetShape& own = graph.shape(facet);
  if (graph.is_wider(facet, large_facet * reach)) return {};
  std::vector<std::pair<double, Index>> found;
  for (const auto& [strip, fold] : graph.neighbors(facet))
    for (const auto& [other, far] : graph.neighbors(strip)) {
      const FacetShape& shape = graph.shape(other);
      const double height = std::abs(graph.height_over(other, own.center));
      if (other == facet || dot(shape.normal, own.normal) < parallel_facets || shape.area <= own.area ||
          height > reach || height <= 4 * graph.flat())
        continue;
      found.push_back({height, other});
    }
  sort_unique(found);
  std::vector<Index> planes;
  for (const auto& [height, other] : found)
    if (std::none_of(planes.begin(), planes.end(), [&](Index g) { return graph.share_plane(g, other); }))
      planes.push_back(other);
  return planes;
}

std::optional<FacetSlide> slide_facet(const FacetGraph& graph, Triangulator& triangulator, Index facet, Index plane,
                                      double reach) {
  return FacetSlider(graph, triangulator, facet, plane, reach).run();
}

}  // namespace bldsimp
