// Pair halfedges: find the twin of each.
#pragma once

#include "mesh/corner_rows.hpp"
#include "mesh/edges.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

struct Halfedges {
  Array<Index> twin;  // -1 where there is none
  // Edges that are not shared by exactly two faces in opposite directions nor used by one face alone:
  // the halfedges of group g are members[start[g]] .. members[start[g + 1] - 1].
  std::vector<Index> group_start{0};
  std::vector<Index> group_members;
  Index open_edges = 0;         // edges of one face
  Index nonmanifold_edges = 0;  // edges of more than two

  // Calls visit(span of halfedges) for each group.
  template <class Visit>
  void for_groups(Visit visit) const {
    for (std::size_t g = 0; g + 1 < group_start.size(); ++g)
      visit(Indices(group_members.data() + group_start[g], group_members.data() + group_start[g + 1]));
  }
};

// Calls visit(lower, higher) for the pairs of an edge's halfedges that alone join the same two rows of the file.
template <class Visit>
void for_row_mates(Indices edge, Faces faces, const CornerRows& rows, Visit visit) {
  std::vector<std::array<Index, 3>> by_rows;
  for (const Index h : edge) {
    const auto [low, high] =
        std::minmax({rows.class_at(h / 3, origin(faces, h)), rows.class_at(h / 3, target(faces, h))});
    by_rows.push_back({low, high, h});
  }
  std::sort(by_rows.begin(), by_rows.end());
  const auto same = [](const auto& a, const auto& b) { return a[0] == b[0] && a[1] == b[1]; };
  for_runs(by_rows, same, [&](auto mates) {
    if (mates.size() == 2) visit(mates[0][2], mates[1][2]);
  });
}

// Twins are the two opposite halfedges of an edge. Where more than two faces meet they are sought
// among those that share the file's own rows, then among those whose faces lie in one plane within
// `width` and face the same way; what is not unique stays without a twin, and so does, of an edge at
// which very many faces meet, what shares no rows. O(halfedges).
Halfedges pair_halfedges(Points points, Faces faces, const CornerRows& rows, double width);

// Edges of one face, and edges of more than two. O(faces).
IndexPair count_edges(Faces faces, Index point_count);

// The edges of one face, as faces without area. O(faces).
std::vector<Face> find_open_edges(Faces faces, Index point_count);

// Points - edges + faces. O(n log n).
Index count_euler(Faces faces);

// The component of each face: its least face. Edges connect faces. Nearly linear.
Array<Index> find_components(Faces faces, Index point_count);

}  // namespace bldsimp
