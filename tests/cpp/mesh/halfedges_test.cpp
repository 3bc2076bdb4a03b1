// Welding and pairing, beside a plain search through all rows and all edges.
#include "mesh/halfedges.hpp"

#include <map>
#include <set>

#include "check.hpp"
#include "mesh/weld.hpp"
#include "shapes.hpp"

using namespace bldsimp;
using shapes::Random;
using shapes::Soup;

namespace {

Soup random_soup(Random& random) {
  Soup soup = shapes::block_with_windows(random, 3, 0.3, 0.5);
  shapes::turn_some(random, soup, 0.1);
  shapes::add_copies(random, soup, 10);
  return soup;
}

void rows_at_one_place_are_one_point() {
  Random random(1);
  for (int round = 0; round < 40; ++round) {
    const Soup soup = random_soup(random);
    const WeldResult welded = weld(soup.points, soup.faces, 0, {});
    const auto less = [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); };
    std::set<Vec3, decltype(less)> places(less);
    for (const Face& f : soup.faces)
      for (const Index row : f) places.insert(soup.points[row]);
    CHECK(std::equal(places.begin(), places.end(), welded.points.begin(), welded.points.end()));
    for (std::size_t f = 0; f < welded.faces.size(); ++f) {
      Face own = soup.faces[welded.source[f]];
      for (Index& row : own) row = welded.point_of_row[row];
      std::rotate(own.begin(), std::min_element(own.begin(), own.end()), own.end());
      CHECK(own == welded.faces[f]);
    }
    CHECK(std::adjacent_find(welded.faces.begin(), welded.faces.end()) == welded.faces.end());
    // Nearer points than the distance are one; the sides of cells are not.
    Soup moved = soup;
    shapes::add_noise(random, moved, 1e-3);
    const WeldResult near = weld(moved.points, moved.faces, 1e-2, {});
    std::set<Index> used(near.point_of_row.begin(), near.point_of_row.end());
    used.erase(-1);
    CHECK(used.size() == welded.points.size() && near.moved > 0);
  }
}

void twins_are_the_two_ways_of_an_edge() {
  Random random(2);
  for (int round = 0; round < 40; ++round) {
    const Soup soup = random_soup(random);
    const WeldResult welded = weld(soup.points, soup.faces, 0, {});
    const std::span<const Face> faces = welded.faces;
    const CornerRows rows{soup.faces, welded.point_of_row, welded.source, welded.class_of_row};
    const Halfedges halfedges = pair_halfedges(welded.points, faces, rows, 0);
    std::map<Edge, std::vector<Index>> edges;
    for (Index h = 0; h < 3 * std::ssize(faces); ++h)
      edges[std::minmax({origin(faces, h), target(faces, h)}).first < target(faces, h)
                ? Edge{origin(faces, h), target(faces, h)}
                : Edge{target(faces, h), origin(faces, h)}]
          .push_back(h);
    Index open = 0, nonmanifold = 0;
    std::set<Index> grouped;
    halfedges.for_groups([&](std::span<const Index> group) { grouped.insert(group.begin(), group.end()); });
    for (const auto& [edge, all] : edges) {
      open += all.size() == 1;
      nonmanifold += all.size() > 2;
      const bool plain = all.size() == 2 && origin(faces, all[0]) != origin(faces, all[1]);
      for (const Index h : all) {
        const Index t = halfedges.twin[h];
        CHECK(grouped.contains(h) == (all.size() > 1 && !plain));
        CHECK(!plain || t == (h == all[0] ? all[1] : all[0]));
        CHECK(t < 0 ||
              (halfedges.twin[t] == h && origin(faces, t) == target(faces, h) && target(faces, t) == origin(faces, h)));
      }
    }
    CHECK(halfedges.open_edges == open && halfedges.nonmanifold_edges == nonmanifold);
    CHECK((count_edges(faces, static_cast<Index>(welded.points.size())) == std::array{open, nonmanifold}));
  }
}

}  // namespace

int main() {
  RUN(rows_at_one_place_are_one_point);
  RUN(twins_are_the_two_ways_of_an_edge);
  return check::report();
}
