#include "mesh/halfedges.hpp"

#include <iterator>

#include "mesh/edges.hpp"
#include "mesh/index_sets.hpp"
#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

// Where more faces than this meet at one edge, their planes are not compared, each with each: what shares
// no rows there is a seam. (Of 40,000 faces round one edge that took 5 s.)
constexpr std::size_t crowd = 64;

struct Pairing {
  Points points;
  Faces faces;
  const CornerRows& rows_of;
  double width;

  Index start(Index h) const { return origin(faces, h); }

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

  // Pairs the two halfedges of an edge that alone join the same two rows, one each way.
  void pair_by_rows(Indices group, Array<Index>& twin) const {
    for_row_mates(group, faces, rows_of, [&](Index h, Index g) {
      if (start(h) == start(g)) return;
      twin[h] = g;
      twin[g] = h;
    });
  }

  // Pairs what lies in one plane: each of the two is the other's only match.
  void pair_by_plane(Indices edge, Array<Index>& twin) const {
    std::vector<Index> group;
    std::copy_if(edge.begin(), edge.end(), std::back_inserter(group), [&](Index h) { return twin[h] < 0; });
    if (group.size() > crowd) return;
    const auto only_match = [&](Index h) {
      Index found = -1;
      for (const Index g : group) {
        if (start(g) == start(h) || !coplanar(h, g)) continue;
        if (found >= 0) return Index{-1};
        found = g;
      }
      return found;
    };
    for (const Index h : group) {
      const Index g = only_match(h);
      if (g < h || only_match(g) != h) continue;
      twin[h] = g;
      twin[g] = h;
    }
  }

  // Pairs the halfedges of one edge, and counts and notes it in `own`.
  void pair(Indices edge, Array<Index>& twin, Halfedges& own) const {
    own.open_edges += edge.size() == 1;
    own.nonmanifold_edges += edge.size() > 2;
    if (edge.size() == 1) return;
    if (edge.size() == 2 && start(edge[0]) != start(edge[1])) {
      twin[edge[0]] = edge[1];
      twin[edge[1]] = edge[0];
      return;
    }
    pair_by_rows(edge, twin);
    pair_by_plane(edge, twin);
    append(own.group_members, edge);
    own.group_start.push_back(static_cast<Index>(own.group_members.size()));
  }
};

}  // namespace

Halfedges pair_halfedges(Points points, Faces faces, const CornerRows& rows, double width) {
  const Pairing pairing{points, faces, rows, width};
  Halfedges result;
  result.twin.assign(3 * faces.size(), -1);
  const EdgeBuckets buckets(faces, static_cast<Index>(points.size()));
  // Each thread has the edges of its own points; what they find is put together in the points' order.
  parallel_collect(
      points.size(),
      [&](std::size_t first, std::size_t last) {
        Halfedges own;
        buckets.visit(static_cast<Index>(first), static_cast<Index>(last),
                      [&](Indices edge) { pairing.pair(edge, result.twin, own); });
        return own;
      },
      [&](const Halfedges& own) {
        const Index before = result.group_start.back();
        for (std::size_t g = 1; g < own.group_start.size(); ++g)
          result.group_start.push_back(before + own.group_start[g]);
        append(result.group_members, own.group_members);
        result.open_edges += own.open_edges;
        result.nonmanifold_edges += own.nonmanifold_edges;
      });
  return result;
}

IndexPair count_edges(Faces faces, Index point_count) {
  IndexPair counts{0, 0};
  EdgeBuckets(faces, point_count).visit(0, point_count, [&](Indices edge) {
    counts[0] += edge.size() == 1;
    counts[1] += edge.size() > 2;
  });
  return counts;
}

std::vector<Face> find_open_edges(Faces faces, Index point_count) {
  std::vector<Face> open;
  EdgeBuckets(faces, point_count).visit(0, point_count, [&](Indices edge) {
    if (edge.size() == 1) open.push_back({origin(faces, edge[0]), target(faces, edge[0]), target(faces, edge[0])});
  });
  return open;
}

Index count_euler(Faces faces) {
  std::vector<Index> points;
  std::vector<Edge> edges;
  for (const auto& [a, b, c] : faces) {
    append(points, std::array{a, b, c});
    append(edges, std::array{Edge{std::min(a, b), std::max(a, b)}, Edge{std::min(b, c), std::max(b, c)},
                             Edge{std::min(c, a), std::max(c, a)}});
  }
  sort_unique(points);
  sort_unique(edges);
  return static_cast<Index>(points.size() - edges.size() + faces.size());
}

Array<Index> find_components(Faces faces, Index point_count) {
  IndexSets sets(faces.size());
  EdgeBuckets(faces, point_count).visit(0, point_count, [&](Indices edge) {
    for (const Index h : edge) sets.join(edge[0] / 3, h / 3);
  });
  return std::move(sets).roots();
}

}  // namespace bldsimp
