// Facets of walls: their planes, loops, neighbors and folds.
#include "details/facet_graph.hpp"

#include "cells.hpp"
#include "check.hpp"

using namespace bldsimp;
using shapes::Cells;
using shapes::Soup;

namespace {

constexpr double kFlat = 1e-6;

FacetGraph graph_of(const Soup& soup) {
  return {soup.points, soup.faces, std::vector<Index>(soup.faces.size(), 0), kFlat};
}

// The facets that face along a direction.
std::vector<Index> facets_along(const FacetGraph& graph, Vec3 way) {
  std::vector<Index> facets;
  for (Index k = 0; k < graph.facet_count(); ++k)
    if (dot(graph.shape(k).normal, way) > 0.999) facets.push_back(k);
  return facets;
}

// The facet that faces along a direction, and is farthest that way.
Index outermost(const FacetGraph& graph, Vec3 way) {
  const auto facets = facets_along(graph, way);
  return *std::max_element(facets.begin(), facets.end(), [&](Index f, Index g) {
    return dot(graph.shape(f).center, way) < dot(graph.shape(g).center, way);
  });
}

Soup wall_with_recess() {
  Cells cells = shapes::wall(2, 0.5, 0.5, {4, 6}, {3, 5});
  cells.fill({1, 1, 1}, {2, 2, 2}, false);
  return cells.surface();
}

void a_box_has_six_facets() {
  const Soup soup = shapes::box({0, 0, 0}, {4, 3, 2});
  const FacetGraph graph = graph_of(soup);
  CHECK(graph.facet_count() == 6);
  const Index top = outermost(graph, {0, 0, 1});
  const FacetShape& shape = graph.shape(top);
  CHECK(shape.normal == (Vec3{0, 0, 1}));
  CHECK(std::abs(shape.offset - 2) < 1e-12);
  CHECK(std::abs(shape.area - 12) < 1e-12);
  CHECK(shape.center == (Vec3{2, 1.5, 2}));
  CHECK(std::abs(shape.radius - 2.5) < 1e-12);
  CHECK(std::abs(graph.width_of(top) - 3) < 1e-6);
  CHECK(std::abs(graph.height_over(top, {0, 0, 5}) - 3) < 1e-12);
  for (Index k = 0; k < 6; ++k) {
    CHECK(graph.faces_of(k).size() == 2);
    CHECK(graph.neighbors(k).size() == 4);
    for (const auto& [other, fold] : graph.neighbors(k)) CHECK(other != k && fold == Fold::convex);
    const auto loops = graph.find_loops(std::array{k});
    CHECK(loops.size() == 1 && loops[0].size() == 4);
    CHECK(std::abs(graph.twice_area(loops[0], graph.shape(k).normal) - 2 * graph.shape(k).area) < 1e-9);
  }
  CHECK(graph.find_open_loops().empty());
}

void a_recess_is_a_loop_of_the_wall() {
  const FacetGraph graph = graph_of(wall_with_recess());
  CHECK(graph.facet_count() == 11);
  const Index front = outermost(graph, {0, -1, 0});
  CHECK(std::abs(graph.shape(front).area - 76) < 1e-9);
  const auto loops = graph.find_loops(std::array{front});
  CHECK(loops.size() == 2);
  double sum = 0;
  Index inner = 0;
  for (const Loop& loop : loops) {
    const double area = graph.twice_area(loop, graph.shape(front).normal);
    sum += area;
    inner += area < 0;
    for (const LoopEdge& e : loop) CHECK(e.outside >= 0 && graph.facet_of(e.outside) != front);
  }
  CHECK(inner == 1);
  CHECK(std::abs(sum - 2 * 76) < 1e-9);
  // The front meets the four ends of the wall and the four reveals, all from outside.
  CHECK(graph.neighbors(front).size() == 8);
  for (const auto& [other, fold] : graph.neighbors(front)) CHECK(fold == Fold::convex);
}

void the_sides_of_a_recess_meet_inwards() {
  const FacetGraph graph = graph_of(wall_with_recess());
  const auto fronts = facets_along(graph, {0, -1, 0});
  CHECK(fronts.size() == 2);
  const Index front = outermost(graph, {0, -1, 0}), back = fronts[0] == front ? fronts[1] : fronts[0];
  CHECK(graph.neighbors(back).size() == 4);
  std::vector<Index> recess{back};
  for (const auto& [reveal, fold] : graph.neighbors(back)) {
    CHECK(fold == Fold::concave);
    recess.push_back(reveal);
    CHECK(std::abs(graph.width_of(reveal) - 0.5) < 1e-6);
    for (const auto& [other, bend] : graph.neighbors(reveal))
      CHECK(bend == (other == front ? Fold::convex : Fold::concave));
  }
  std::sort(recess.begin(), recess.end());
  const auto loops = graph.find_loops(recess);
  CHECK(loops.size() == 1 && loops[0].size() == 4);
  for (const LoopEdge& e : loops[0]) CHECK(graph.facet_of(e.outside) == front);
  // It runs as a cap would that takes the recess's place.
  CHECK(std::abs(graph.twice_area(loops[0], graph.shape(front).normal) - 8) < 1e-9);
}

void facets_on_both_sides_of_a_groove_share_a_plane() {
  Cells cells = shapes::wall(2, 0.5, 0.5, {4, 6}, {3, 5});
  cells.fill({1, 1, 0}, {2, 2, 3}, false);
  const Soup soup = cells.surface();
  const FacetGraph graph = graph_of(soup);
  const auto fronts = facets_along(graph, {0, -1, 0});
  CHECK(fronts.size() == 3);
  Index pairs = 0;
  for (const Index f : fronts)
    for (const Index g : fronts) pairs += f < g && graph.share_plane(f, g);
  CHECK(pairs == 1);
  // Nor with the wall's back, which faces the other way; nor with what has another label.
  CHECK(!graph.share_plane(fronts[0], facets_along(graph, {0, 1, 0})[0]));
  std::vector<Index> label(soup.faces.size(), 0);
  for (std::size_t f = 0; f < soup.faces.size(); ++f) label[f] = soup.points[soup.faces[f][0]].x >= 6;
  const FacetGraph labeled(soup.points, soup.faces, label, kFlat);
  const Index left = outermost(labeled, {0, -1, 0});
  for (const Index k : facets_along(labeled, {0, -1, 0})) CHECK(labeled.continues(left, k) == (left == k));
}

void what_is_missing_leaves_an_open_loop() {
  Soup soup = wall_with_recess();
  const auto in_back = [&](const Face& f) {
    return std::all_of(f.begin(), f.end(), [&](Index p) { return soup.points[p].y == 0.5; });
  };
  std::erase_if(soup.faces, in_back);
  const FacetGraph graph = graph_of(soup);
  CHECK(graph.facet_count() == 10);
  const auto open = graph.find_open_loops();
  CHECK(open.size() == 1 && open[0].size() == 4);
  CHECK(std::abs(graph.twice_area(open[0], {0, -1, 0}) - 8) < 1e-9);
  for (std::size_t i = 0; i < open[0].size(); ++i) {
    CHECK(open[0][i].to == open[0][(i + 1) % 4].from);
    CHECK(open[0][i].outside >= 0);
  }
}

void nothing_has_no_facets() {
  const FacetGraph graph({}, {}, {}, kFlat);
  CHECK(graph.facet_count() == 0);
  CHECK(graph.find_open_loops().empty());
}

}  // namespace

int main() {
  RUN(a_box_has_six_facets);
  RUN(a_recess_is_a_loop_of_the_wall);
  RUN(the_sides_of_a_recess_meet_inwards);
  RUN(facets_on_both_sides_of_a_groove_share_a_plane);
  RUN(what_is_missing_leaves_an_open_loop);
  RUN(nothing_has_no_facets);
  return check::report();
}
