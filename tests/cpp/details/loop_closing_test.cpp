// Each rule by which the loops around a detail are closed.
#include "details/loop_closing.hpp"

#include "cells.hpp"
#include "check.hpp"

using namespace bldsimp;
using shapes::Cells;
using shapes::Soup;

namespace {

constexpr double kFlat = 1e-6;

// A wall of 10 x 2 x 8 from which a box is cut, and the facets that this made.
struct Cut {
  Soup soup;
  std::vector<Index> label;
  std::array<Vec3, 2> box;

  Cut(const std::array<Index, 3>& low, const std::array<Index, 3>& high, double depth = 0.5) {
    Cells cells = shapes::wall(2, depth, 0.5, {4, 6}, {3, 5});
    cells.fill(low, high, false);
    soup = cells.surface();
    label.assign(soup.faces.size(), 0);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& at = i ? high : low;
      box[i] = {cells.lines[0][at[0]], cells.lines[1][at[1]], cells.lines[2][at[2]]};
    }
  }
  FacetGraph graph() const { return {soup.points, soup.faces, label, kFlat}; }
  // Facets of which all is in the box.
  std::vector<Index> facets(const FacetGraph& graph) const {
    std::vector<Index> found;
    for (Index k = 0; k < graph.facet_count(); ++k) {
      const auto& [low, high] = graph.shape(k).box;
      if (low.x >= box[0].x && low.y >= box[0].y && low.z >= box[0].z && high.x <= box[1].x && high.y <= box[1].y &&
          high.z <= box[1].z)
        found.push_back(k);
    }
    return found;
  }
};

std::vector<Vec3> places_after(const FacetGraph& graph, const Caps& caps) {
  std::vector<Vec3> places(graph.points().begin(), graph.points().end());
  for (const auto& [p, to] : caps.moved) places[p] = to;
  return places;
}

// The volume of what a closed surface encloses, sixfold.
double measure_volume(Points points, Faces faces) {
  double sum = 0;
  for (const auto& [a, b, c] : faces) sum += dot(points[a], cross(points[b], points[c]));
  return sum;
}

// Closes what a cut made: the whole wall comes back, with so many caps, each in the plane of its parent.
void check_closing(const Cut& cut, std::size_t loops, std::size_t faces, std::size_t moved) {
  const FacetGraph graph = cut.graph();
  const auto facets = cut.facets(graph);
  const auto around = graph.find_loops(facets);
  CHECK(around.size() == loops);
  LoopCloser closer(graph);
  const auto caps = closer.close(around, facets, 0);
  CHECK(caps.has_value());
  if (!caps) return;
  CHECK(caps->faces.size() == faces && caps->parent.size() == faces);
  CHECK(caps->moved.size() == moved);
  const auto places = places_after(graph, *caps);
  std::vector<Face> all(caps->faces);
  for (std::size_t c = 0; c < caps->faces.size(); ++c)
    for (const Index p : caps->faces[c])
      CHECK(std::abs(graph.height_over(graph.facet_of(caps->parent[c]), places[p])) < 1e-9);
  for (Index f = 0; f < std::ssize(cut.soup.faces); ++f)
    if (!std::binary_search(facets.begin(), facets.end(), graph.facet_of(f))) all.push_back(cut.soup.faces[f]);
  const IndexPair edges = count_edges(all, static_cast<Index>(places.size()));
  CHECK(edges[0] == 0 && edges[1] == 0);
  CHECK(std::abs(measure_volume(places, all) - 6 * 160) < 1e-6);
}

void one_plane_closes_a_recess() { check_closing(Cut({1, 1, 1}, {2, 2, 2}), 1, 2, 0); }

void each_end_of_a_passage_is_closed_in_its_wall() { check_closing(Cut({1, 1, 1}, {2, 2, 2}, 2), 2, 4, 0); }

void two_planes_close_a_notch_at_an_edge() { check_closing(Cut({2, 1, 1}, {3, 2, 2}), 1, 4, 0); }

void a_chord_between_two_runs_closes_a_groove() { check_closing(Cut({1, 1, 0}, {2, 2, 3}), 1, 10, 0); }

void three_planes_meet_where_a_corner_is_bitten_off() { check_closing(Cut({2, 1, 2}, {3, 2, 3}), 1, 6, 1); }

void what_has_no_plane_around_stays_open() {
  // The back of a recess alone: its border is in the planes of the four reveals.
  const Cut cut({1, 1, 1}, {2, 2, 2});
  const FacetGraph graph = cut.graph();
  const auto facets = cut.facets(graph);
  for (const Index k : facets) {
    LoopCloser closer(graph);
    if (std::abs(graph.shape(k).normal.y) > 0.5)
      CHECK(!closer.close(graph.find_loops(std::array{k}), std::array{k}, 0));
  }
}

void what_is_open_in_part_stays_open() {
  Cut cut({1, 1, 1}, {2, 2, 2});
  // Without the wall's lower part there is no facet below the recess.
  std::erase_if(cut.soup.faces, [&](const Face& f) {
    return std::all_of(f.begin(), f.end(),
                       [&](Index p) { return cut.soup.points[p].y == 0 && cut.soup.points[p].z <= 3; });
  });
  cut.label.resize(cut.soup.faces.size());
  const FacetGraph graph = cut.graph();
  const auto facets = cut.facets(graph);
  LoopCloser closer(graph);
  CHECK(!closer.close(graph.find_loops(facets), facets, 0));
  CHECK(closer.why() == Unclosed::open);
}

void labels_around_an_opening_do_not_mix() {
  // Two labels meet in the middle of the recess's upper and lower edge.
  Cells cells({std::vector<double>{0, 4, 5, 6, 10}, std::vector<double>{0, 0.5, 2}, std::vector<double>{0, 3, 5, 8}});
  cells.fill({0, 0, 0}, {4, 2, 3}, true);
  cells.fill({1, 0, 1}, {3, 1, 2}, false);
  const Soup soup = cells.surface();
  std::vector<Index> label;
  for (const Face& f : soup.faces) label.push_back(centroid(corners_of(f, soup.points)).x > 5);
  const FacetGraph graph(soup.points, soup.faces, label, kFlat);
  std::vector<Index> facets;
  for (Index k = 0; k < graph.facet_count(); ++k) {
    const auto& [low, high] = graph.shape(k).box;
    if (low.x >= 4 && high.x <= 6 && high.y <= 0.5 && low.z >= 3 && high.z <= 5) facets.push_back(k);
  }
  const auto loops = graph.find_loops(facets);
  CHECK(loops.size() == 1 && loops[0].size() == 6);
  LoopCloser closer(graph);
  const auto caps = closer.close(loops, facets, 0);
  // Where it is closed at all, each cap is on the side of its own label.
  for (std::size_t c = 0; caps && c < caps->faces.size(); ++c)
    CHECK((centroid(corners_of(caps->faces[c], soup.points)).x > 5) == (label[caps->parent[c]] == 1));
}

void loops_alone_can_be_closed_or_not() {
  const Cut recess({1, 1, 1}, {2, 2, 2}), corner({2, 1, 2}, {3, 2, 3});
  const FacetGraph graph = recess.graph(), other = corner.graph();
  LoopCloser closer(graph), without_point(other);
  CHECK(closer.can_close(graph.find_loops(recess.facets(graph))[0]));
  // Where three planes meet there must be a point.
  CHECK(!without_point.can_close(other.find_loops(corner.facets(other))[0]));
}

}  // namespace

int main() {
  RUN(one_plane_closes_a_recess);
  RUN(each_end_of_a_passage_is_closed_in_its_wall);
  RUN(two_planes_close_a_notch_at_an_edge);
  RUN(a_chord_between_two_runs_closes_a_groove);
  RUN(three_planes_meet_where_a_corner_is_bitten_off);
  RUN(what_has_no_plane_around_stays_open);
  RUN(what_is_open_in_part_stays_open);
  RUN(labels_around_an_opening_do_not_mix);
  RUN(loops_alone_can_be_closed_or_not);
  return check::report();
}
