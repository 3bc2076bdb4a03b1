// The triangulation on random graphs: crowded grids, near-coincident crossings, lifted planes.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "cdt/cdt.hpp"
#include "check.hpp"

using namespace bldsimp;

namespace {

using Segments = std::vector<Triangulator::Segment>;
std::mt19937_64 generator(17);

Index below(std::size_t limit) { return static_cast<Index>(generator() % limit); }

// Counter-clockwise triangles, neighbors that agree, each piece an edge unless carved away, and
// every free edge Delaunay (by `wants_flip`, given the two points beside it).
template <class Criterion>
void check_net(const Triangulator& t, bool carved, const Criterion& wants_flip) {
  const auto points = t.points();
  std::map<std::pair<Index, Index>, std::pair<Index, Index>> edges;  // to triangle, apex
  std::set<std::pair<Index, Index>> pieces;
  for (const auto& piece : t.pieces()) {
    pieces.insert({piece.a, piece.b});
    pieces.insert({piece.b, piece.a});
  }
  for (Index row = 0; row < static_cast<Index>(t.triangles().size()); ++row) {
    const auto& triangle = t.triangles()[row];
    CHECK(orient2d(points[triangle[0]], points[triangle[1]], points[triangle[2]]) > 0);
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(edges.insert({{triangle[i], triangle[(i + 1) % 3]}, {row, triangle[(i + 2) % 3]}}).second);
  }
  for (const auto& [edge, here] : edges) {
    const auto across = edges.find({edge.second, edge.first});
    const auto& triangle = t.triangles()[here.first];
    const auto found = std::find(triangle.begin(), triangle.end(), here.second);
    const auto corner = static_cast<std::size_t>(found - triangle.begin());
    CHECK(t.neighbors()[here.first][corner] == (across == edges.end() ? -1 : across->second.first));
    if (across != edges.end() && pieces.count(edge) == 0)
      CHECK(!wants_flip(edge.first, edge.second, here.second, across->second.second));
  }
  if (!carved && !t.triangles().empty())
    for (const auto& edge : pieces) CHECK(edges.count(edge) + edges.count({edge.second, edge.first}) > 0);
}

void check_plain(const Triangulator& t, bool carved) {
  const auto points = t.points();
  check_net(t, carved, [&](Index a, Index b, Index p, Index q) {
    return incircle(points[a], points[b], points[p], points[q]) > 0;
  });
}

void crowded_grids() {
  Triangulator workspace;
  int crossings = 0;
  for (int round = 0; round < 4000; ++round) {
    const std::size_t count = 1 + generator() % 20, size = 2 + generator() % 7;
    std::vector<Point2> points(count);
    for (Point2& p : points) p = {static_cast<double>(below(size)), static_cast<double>(below(size))};
    Segments segments(generator() % 12);
    for (auto& segment : segments) segment = {below(count), below(count)};
    const bool carve = round % 2 == 0, split = round % 3 == 0;
    const Status status = workspace.run(points, segments, {.carve = carve, .split_crossings = split});
    if (status == Status::done) {
      check_plain(workspace, carve);
      continue;
    }
    ++crossings;
    CHECK(!split);
    const auto end = [&](std::size_t which, std::size_t i) { return points[segments[workspace.crossing()[which]][i]]; };
    CHECK(orient2d(end(0, 0), end(0, 1), end(1, 0)) * orient2d(end(0, 0), end(0, 1), end(1, 1)) < 0);
    CHECK(orient2d(end(1, 0), end(1, 1), end(0, 0)) * orient2d(end(1, 0), end(1, 1), end(0, 1)) < 0);
  }
  CHECK(crossings > 100);
}

// Lines through one point, off by units in the last place: rounded crossings fall on each other.
void pencils_of_lines() {
  Triangulator workspace;
  for (int round = 0; round < 60; ++round) {
    std::uniform_real_distribution<double> angle(0.0, 3.14), length(0.5, 9.0), middle(-1.0, 1.0);
    const Point2 center{middle(generator), middle(generator)};
    std::vector<Point2> points;
    Segments segments;
    for (Index i = 0; i < 16; ++i) {
      const double phi = angle(generator), r = length(generator);
      const double off = static_cast<double>(below(5)) * 0x1p-52;
      points.push_back({center.x + off - r * std::cos(phi), center.y - r * std::sin(phi)});
      points.push_back({center.x + off + r * std::cos(phi), center.y + r * std::sin(phi)});
      segments.push_back({2 * i, 2 * i + 1});
    }
    CHECK(workspace.run(points, segments, {.carve = false, .split_crossings = true}) == Status::done);
    check_plain(workspace, false);
    CHECK(workspace.points().size() < 32 + 16 * 16);
  }
}

// Points of the plane z = x + y, dropped to x, y: lifted by their squared length in space they are
// triangulated as in their plane, where the criterion is exact in whole numbers.
void lifted_planes() {
  Triangulator workspace;
  for (int round = 0; round < 500; ++round) {
    std::vector<Point2> points(4 + generator() % 30);
    std::vector<double> lift;
    for (Point2& p : points) {
      p = {static_cast<double>(below(40)), static_cast<double>(below(40))};
      lift.push_back(p.x * p.x + p.y * p.y + (p.x + p.y) * (p.x + p.y));
    }
    CHECK(workspace.run(points, {}, {.carve = false, .lift = lift.data()}) == Status::done);
    check_net(workspace, false, [&](Index a, Index b, Index p, Index q) {
      const auto lifted = [&](Index i) { return Point3{points[i].x, points[i].y, lift[i]}; };
      return orient3d(lifted(a), lifted(b), lifted(p), lifted(q)) > 0;
    });
  }
}

// Lifts that are no convex function at all: flips must end, and the net must stay one.
void any_lift_ends() {
  Triangulator workspace;
  for (int round = 0; round < 500; ++round) {
    std::vector<Point2> points(4 + generator() % 30);
    std::vector<double> lift;
    for (Point2& p : points) {
      p = {static_cast<double>(below(12)), static_cast<double>(below(12))};
      lift.push_back(static_cast<double>(below(9)));
    }
    Segments segments;
    for (int i = 0; i < 6; ++i) segments.push_back({below(points.size()), below(points.size())});
    const TriangulateOptions options{.carve = false, .split_crossings = true, .lift = lift.data()};
    CHECK(workspace.run(points, segments, options) == Status::done);
    check_net(workspace, false, [](Index, Index, Index, Index) { return false; });
  }
}

// Without recovery a segment is missing exactly where the net of the points alone has no such edge, and
// without poles all directions are told by determinants; what can be made is the same.
void standard_method() {
  Triangulator standard, improved;
  int whole = 0, with_missing = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<Point2> points(3 + generator() % 12);
    for (Point2& p : points) p = {static_cast<double>(below(9)), static_cast<double>(below(9))};
    Segments segments(1 + generator() % 4);
    for (auto& segment : segments) segment = {below(points.size()), below(points.size())};
    CHECK(standard.run(points, segments, {.carve = false, .recover = false, .poles = false}) == Status::done);
    CHECK(standard.statistics().by_poles == 0);
    CHECK(improved.run(points, {}, {.carve = false}) == Status::done);
    CHECK(standard.statistics().by_determinant ==
          improved.statistics().by_poles + improved.statistics().by_determinant);
    CHECK(standard.statistics().flips == improved.statistics().flips);
    if (improved.triangles().empty()) continue;
    std::set<std::pair<Index, Index>> edges;
    for (const auto& t : improved.triangles())
      for (int i = 0; i < 3; ++i) edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
    std::vector<Index> missing;
    for (Index s = 0; s < std::ssize(segments); ++s) {
      const Index a = improved.point_of_input()[segments[s][0]], b = improved.point_of_input()[segments[s][1]];
      if (a != b && !edges.contains(std::minmax(a, b))) missing.push_back(s);
    }
    CHECK(standard.missing() == missing);
    if (missing.empty()) {
      ++whole;
      CHECK(standard.triangles() == improved.triangles());
      check_plain(standard, false);
    } else {
      ++with_missing;
      CHECK(standard.triangles().empty() && standard.pieces().empty());
    }
  }
  CHECK(whole > 100 && with_missing > 100);
  CHECK(improved.run(std::vector<Point2>{{0, 0}, {1, 0}, {0, 1}}, {}, {.carve = false}) == Status::done);
  CHECK(improved.missing().empty());
}

void workspace_forgets() {
  const std::vector<Point2> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const Segments ring{{0, 1}, {1, 2}, {2, 3}, {3, 0}};
  const Segments crossed{{0, 2}, {1, 3}};
  Triangulator workspace;
  CHECK(workspace.run(square, ring) == Status::done);
  const auto first = workspace.triangles();
  CHECK(first.size() == 2);
  CHECK(workspace.run(square, crossed) == Status::crossing);
  CHECK((workspace.crossing() == Triangulator::Segment{0, 1}));
  CHECK(workspace.run({}, {}) == Status::done);
  CHECK(workspace.triangles().empty() && workspace.points().empty());
  CHECK(workspace.run(square, ring) == Status::done);
  CHECK(workspace.triangles() == first);
  CHECK(workspace.release().triangles == first);
  CHECK(workspace.run(square, ring) == Status::done);
  CHECK(workspace.triangles() == first);
}

void large_random_points() {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Point2> points(20000);
  for (Point2& p : points) p = {unit(generator), unit(generator)};
  Triangulator workspace;
  CHECK(workspace.run(points, {}, {.carve = false}) == Status::done);
  check_plain(workspace, false);
  CHECK(workspace.statistics().walked < 4 * workspace.statistics().located);
  CHECK(workspace.statistics().by_poles > workspace.statistics().located);
}

}  // namespace

int main() {
  RUN(crowded_grids);
  RUN(pencils_of_lines);
  RUN(lifted_planes);
  RUN(any_lift_ends);
  RUN(standard_method);
  RUN(workspace_forgets);
  RUN(large_random_points);
  return check::report();
}
