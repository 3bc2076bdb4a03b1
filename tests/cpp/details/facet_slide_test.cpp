// Small facets slide into the plane of a larger one beside them.
#include "details/facet_slide.hpp"

#include "cells.hpp"
#include "check.hpp"

using namespace bldsimp;
using shapes::Cells;
using shapes::Soup;

namespace {

constexpr double kFlat = 1e-6, kReach = 0.6;

// A window through a wall, and a sill below it, as wide and with its top in the plane of the reveal; 0.5 deep.
Soup window_with_sill() {
  Cells cells = shapes::wall(2, 2, 0.5, {4, 6}, {2, 3, 6});
  cells.fill({1, 1, 2}, {2, 2, 3}, false);
  cells.fill({1, 0, 1}, {2, 1, 2}, true);
  return cells.surface();
}

Index find_front(const FacetGraph& graph, double y) {
  for (Index k = 0; k < graph.facet_count(); ++k)
    if (graph.shape(k).normal.y < -0.999 && std::abs(graph.shape(k).center.y - y) < 1e-9) return k;
  return -1;
}

std::vector<Face> faces_after(const FacetGraph& graph, const FacetSlide& slide) {
  std::vector<Face> faces(slide.caps.faces);
  for (Index f = 0; f < std::ssize(graph.faces()); ++f)
    if (!std::binary_search(slide.gone.begin(), slide.gone.end(), f)) faces.push_back(graph.faces()[f]);
  return faces;
}

void the_front_of_a_sill_slides_into_the_wall() {
  const Soup soup = window_with_sill();
  const std::vector<Index> label(soup.faces.size(), 0);
  const FacetGraph graph(soup.points, soup.faces, label, kFlat);
  const Index front = find_front(graph, -0.5), wall = find_front(graph, 0);
  CHECK(front >= 0 && wall >= 0);
  const auto planes = find_slide_planes(graph, front, kReach);
  CHECK(planes.size() == 1 && graph.share_plane(planes[0], wall));
  Triangulator triangulator;
  const auto slide = slide_facet(graph, triangulator, front, wall, kReach);
  CHECK(slide.has_value());
  if (!slide) return;
  // The four corners become those of the window and of the wall below it.
  CHECK(slide->caps.moved.empty());
  CHECK(slide->caps.faces.size() < slide->gone.size());
  CHECK(slide->caps.parent.size() == slide->caps.faces.size());
  CHECK(std::is_sorted(slide->gone.begin(), slide->gone.end()));
  const auto faces = faces_after(graph, *slide);
  const IndexPair edges = count_edges(faces, static_cast<Index>(soup.points.size()));
  CHECK(edges[0] == 0 && edges[1] == 0);
  for (const Face& f : faces)
    for (const Index p : f) CHECK(soup.points[p].y >= 0);
}

void nothing_slides_farther_than_it_may() {
  const Soup soup = window_with_sill();
  const std::vector<Index> label(soup.faces.size(), 0);
  const FacetGraph graph(soup.points, soup.faces, label, kFlat);
  const Index front = find_front(graph, -0.5), wall = find_front(graph, 0);
  Triangulator triangulator;
  CHECK(find_slide_planes(graph, front, 0.4).empty());
  CHECK(!slide_facet(graph, triangulator, front, wall, 0.4));
}

void a_large_facet_stays() {
  const Soup soup = window_with_sill();
  const std::vector<Index> label(soup.faces.size(), 0);
  const FacetGraph graph(soup.points, soup.faces, label, kFlat);
  CHECK(find_slide_planes(graph, find_front(graph, 0), kReach).empty());
}

void points_between_planes_move_along_them() {
  // A block on a larger one, flush with two of its sides: the top of the higher one comes down.
  Cells cells({std::vector<double>{0, 2, 10}, std::vector<double>{0, 1, 8}, std::vector<double>{0, 5, 5.5}});
  cells.fill({0, 0, 0}, {2, 2, 1}, true);
  cells.fill({0, 0, 1}, {1, 1, 2}, true);
  const Soup soup = cells.surface();
  const std::vector<Index> label(soup.faces.size(), 0);
  const FacetGraph graph(soup.points, soup.faces, label, kFlat);
  Index high = -1, low = -1;
  for (Index k = 0; k < graph.facet_count(); ++k) {
    if (graph.shape(k).normal.z < 0.999) continue;
    (graph.shape(k).center.z > 5.2 ? high : low) = k;
  }
  const auto planes = find_slide_planes(graph, high, kReach);
  CHECK(planes.size() == 1 && planes[0] == low);
  Triangulator triangulator;
  const auto slide = slide_facet(graph, triangulator, high, low, kReach);
  CHECK(slide.has_value());
  if (!slide) return;
  auto places = soup.points;
  for (const auto& [p, to] : slide->caps.moved) places[p] = to;
  const auto faces = faces_after(graph, *slide);
  const IndexPair edges = count_edges(faces, static_cast<Index>(places.size()));
  CHECK(edges[0] == 0 && edges[1] == 0);
  double volume = 0;
  for (const auto& [a, b, c] : faces) volume += dot(places[a], cross(places[b], places[c]));
  CHECK(std::abs(volume - 6 * 400) < 1e-6);
}

}  // namespace

int main() {
  RUN(the_front_of_a_sill_slides_into_the_wall);
  RUN(nothing_slides_farther_than_it_may);
  RUN(a_large_facet_stays);
  RUN(points_between_planes_move_along_them);
  return check::report();
}
