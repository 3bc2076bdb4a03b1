// Polygons of files: the faces use every edge as the outline does, whatever the outline.
#include "cdt/polygons.hpp"

#include <map>
#include <random>
#include <vector>

#include "check.hpp"

using namespace bldsimp;

namespace {

std::mt19937_64 generator(23);

PolygonFaces cut(const std::vector<Point3>& points, const std::vector<Index>& corners) {
  const std::vector<std::int64_t> offsets{0, static_cast<std::int64_t>(corners.size())};
  return triangulate_polygons(points, offsets, corners);
}

// Uses of each edge, forward minus backward.
std::map<std::pair<Index, Index>, int> balance(const std::vector<std::vector<Index>>& cycles) {
  std::map<std::pair<Index, Index>, int> uses;
  for (const auto& cycle : cycles)
    for (std::size_t i = 0; i < cycle.size(); ++i) {
      const Index a = cycle[i], b = cycle[(i + 1) % cycle.size()];
      if (a != b) uses[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  std::erase_if(uses, [](const auto& use) { return use.second == 0; });
  return uses;
}

void check_outline(const std::vector<Point3>& points, const std::vector<Index>& corners) {
  const PolygonFaces result = cut(points, corners);
  std::vector<std::vector<Index>> faces;
  for (const auto& face : result.faces) faces.emplace_back(face.begin(), face.end());
  CHECK(balance(faces) == balance({corners}));
  CHECK(result.polygon_of_face.size() == result.faces.size());
}

void concave_quadrilateral() {
  const std::vector<Point3> arrow{{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {0, 4, 0}};
  for (Index turn = 0; turn < 4; ++turn) {
    const std::vector<Index> corners{turn, (turn + 1) % 4, (turn + 2) % 4, (turn + 3) % 4};
    const PolygonFaces result = cut(arrow, corners);
    CHECK(result.faces.size() == 2);
    for (const auto& face : result.faces) {
      const Point3 &a = arrow[face[0]], &b = arrow[face[1]], &c = arrow[face[2]];
      CHECK(orient2d({a.x, a.y}, {b.x, b.y}, {c.x, c.y}) > 0);
    }
    check_outline(arrow, corners);
  }
}

void winding_is_the_polygons() {
  const std::vector<Point3> wall{{0, 0, 0}, {0, 0, 3}, {5, 0, 3}, {5, 0, 1}, {2, 0, 0}};
  check_outline(wall, {0, 1, 2, 3, 4});
  check_outline(wall, {4, 3, 2, 1, 0});
  CHECK(cut(wall, {0, 1, 2, 3, 4}).faces.size() == 3);
}

void collinear_corners_stay() {
  const std::vector<Point3> square{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}};
  const PolygonFaces result = cut(square, {0, 1, 2, 3, 4, 5, 6});
  CHECK(result.faces.size() == 5);
  check_outline(square, {0, 1, 2, 3, 4, 5, 6});
}

void all_collinear() {
  const std::vector<Point3> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}};
  check_outline(line, {0, 1, 2, 3});
  CHECK(cut(line, {0, 1}).faces.empty());
  CHECK(cut(line, {0, 0, 0, 0}).faces.empty());
}

void corner_on_an_edge() {
  const std::vector<Point3> points{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0, 0}, {0, 4, 0}};
  check_outline(points, {0, 1, 2, 3, 4});
}

void bridge_to_a_hole() {
  const std::vector<Point3> points{{0, 0, 0}, {6, 0, 0}, {6, 6, 0}, {0, 6, 0},
                                   {2, 2, 0}, {2, 4, 0}, {4, 4, 0}, {4, 2, 0}};
  const std::vector<Index> corners{0, 1, 2, 3, 0, 4, 5, 6, 7, 4};
  CHECK(cut(points, corners).faces.size() == 8);
  check_outline(points, corners);
}

void triangles_pass_through() {
  const std::vector<Point3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  const std::vector<std::int64_t> offsets{0, 3, 7, 10};
  const std::vector<Index> corners{2, 0, 1, 0, 1, 3, 2, 3, 3, 1};
  const PolygonFaces result = triangulate_polygons(points, offsets, corners);
  CHECK((result.faces.front() == std::array<Index, 3>{2, 0, 1}));
  CHECK((result.faces.back() == std::array<Index, 3>{3, 3, 1}));
  CHECK((result.polygon_of_face == std::vector<Index>{0, 1, 1, 2}));
}

// Crossing, touching and repeating outlines, flat or not.
void any_outline() {
  for (int round = 0; round < 20000; ++round) {
    const std::size_t size = 2 + generator() % 5;
    std::vector<Point3> points(3 + generator() % 8);
    for (Point3& p : points)
      p = {static_cast<double>(generator() % size), static_cast<double>(generator() % size),
           round % 2 == 0 ? 0.0 : static_cast<double>(generator() % size)};
    std::vector<Index> corners(4 + generator() % 8);
    for (Index& corner : corners) corner = static_cast<Index>(generator() % points.size());
    const PolygonFaces result = cut(points, corners);
    // Points that coincide in space are one.
    const auto place = [&](Index i) {
      for (Index j = 0; j < i; ++j)
        if (points[i].x == points[j].x && points[i].y == points[j].y && points[i].z == points[j].z) return j;
      return i;
    };
    std::vector<std::vector<Index>> faces, outline(1);
    for (const auto& face : result.faces) faces.push_back({place(face[0]), place(face[1]), place(face[2])});
    for (const Index corner : corners) outline[0].push_back(place(corner));
    CHECK(balance(faces) == balance(outline));
  }
}

}  // namespace

int main() {
  RUN(concave_quadrilateral);
  RUN(winding_is_the_polygons);
  RUN(collinear_corners_stay);
  RUN(all_collinear);
  RUN(corner_on_an_edge);
  RUN(bridge_to_a_hole);
  RUN(triangles_pass_through);
  RUN(any_outline);
  return check::report();
}
