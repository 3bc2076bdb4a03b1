#include "halfedges.hpp"

#include "edges.hpp"

namespace bldsimp {
namespace {

struct Pairing {
  std::span<const Vec3> points;
  std::span<const Face> faces;
  std::span<const Index> row_of_corner;
  double width;

  Index start(Index h) const { return origin(faces, h); }

  bool same_rows(Index h, Index g) const {
    return row_of_corner[h] == row_of_corner[next_halfedge(g)] &&
           row_of_corner[next_halfedge(h)] == row_of_corner[g];
  }

  // The faces lie in one plane, on both sides of the edge, and face the same way.
  bool coplanar(Index h, Index g) const {
    const Vec3 a = points[start(h)], b = points[target(faces, h)];
    const Vec3 n = cross(b - a, points[apex(faces, h)] - a), m = cross(a - b, points[apex(faces, g)] - b);
    if (dot(n, m) <= 0) return false;
    const bool first_is_larger = dot(n, n) >= dot(m, m);
    const Vec3 normal = first_is_larger ? n : m;
    const Vec3 tip = points[apex(faces, first_is_larger ? g : h)];
    return std::abs(dot(normal, tip - a)) <= width * length(normal);
  }

  // Pairs what `matches` pairs uniquely: each of the two is the other's only match.
  template <class Matches>
  void pair_unique(std::span<const Index> group, std::vector<Index>& twin, Matches matches) const {
    const auto only_match = [&](Index h) {
      Index found = -1;
      for (const Index g : group) {
        if (twin[g] >= 0 || start(g) == start(h) || !matches(h, g)) continue;
        if (found >= 0) return Index{-1};
        found = g;
      }
      return found;
    };
    std::vector<std::array<Index, 2>> pairs;
    for (const Index h : group) {
      if (twin[h] >= 0) continue;
      const Index g = only_match(h);
      if (g > h && only_match(g) == h) pairs.push_back({h, g});
    }
    for (const auto [h, g] : pairs) {
      twin[h] = g;
      twin[g] = h;
    }
  }
};

}  // namespace

Halfedges pair_halfedges(std::span<const Vec3> points, std::span<const Face> faces,
                         std::span<const Index> row_of_corner, double width) {
  const Pairing pairing{points, faces, row_of_corner, width};
  Halfedges result;
  result.twin.assign(3 * faces.size(), -1);
  for_each_edge(faces, static_cast<Index>(points.size()), [&](std::span<const Index> edge) {
    result.open_edges += edge.size() == 1;
    result.nonmanifold_edges += edge.size() > 2;
    if (edge.size() == 1) return;
    if (edge.size() == 2 && pairing.start(edge[0]) != pairing.start(edge[1])) {
      result.twin[edge[0]] = edge[1];
      result.twin[edge[1]] = edge[0];
      return;
    }
    pairing.pair_unique(edge, result.twin, [&](Index g, Index h) { return pairing.same_rows(g, h); });
    pairing.pair_unique(edge, result.twin, [&](Index g, Index h) { return pairing.coplanar(g, h); });
    result.group_members.insert(result.group_members.end(), edge.begin(), edge.end());
    result.group_start.push_back(static_cast<Index>(result.group_members.size()));
  });
  return result;
}

std::array<Index, 2> count_edges(std::span<const Face> faces, Index point_count) {
  std::array<Index, 2> counts{0, 0};
  for_each_edge(faces, point_count, [&](std::span<const Index> edge) {
    counts[0] += edge.size() == 1;
    counts[1] += edge.size() > 2;
  });
  return counts;
}

}  // namespace bldsimp
