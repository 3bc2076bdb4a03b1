// The tree of boxes beside a search through all faces, in one thread and in several.
#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "check.hpp"
#include "mesh/certificate.hpp"
#include "mesh/distances.hpp"
#include "mesh/framed_triangle.hpp"

using namespace bldsimp;

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

std::vector<Vec3> random_points(std::mt19937_64& generator, std::size_t count) {
  std::uniform_real_distribution<double> place(-1, 1);
  std::vector<Vec3> points(count);
  for (Vec3& p : points) p = {place(generator), place(generator), place(generator)};
  return points;
}

// Faces between any three points: some repeat one, so that they are segments or mere points.
std::vector<Face> random_faces(std::mt19937_64& generator, std::size_t count, Index points) {
  std::uniform_int_distribution<Index> corner(0, points - 1);
  std::vector<Face> faces(count);
  for (Face& face : faces)
    for (Index& index : face) index = corner(generator);
  return faces;
}

void the_tree_finds_the_nearest_of_all_faces() {
  std::mt19937_64 generator(1);
  for (const std::size_t count : {1, 4, 5, 9, 64, 300}) {
    const auto points = random_points(generator, 20);
    const auto faces = random_faces(generator, count, 20);
    const auto queries = random_points(generator, 5000);
    std::vector<double> nearest(queries.size(), kFar);
    for (const Face& face : faces) {
      const auto alone = FaceTree(points, {&face, 1}).distances(queries);
      for (std::size_t i = 0; i < queries.size(); ++i) nearest[i] = std::min(nearest[i], alone[i]);
    }
    const FaceTree tree(points, faces);
    const auto found = tree.distances(queries);
    CHECK(std::equal(found.begin(), found.end(), nearest.begin(),
                     [](double a, double b) { return std::abs(a - b) < 1e-15; }));
    const double greatest = *std::max_element(found.begin(), found.end());
    CHECK(tree.farthest(queries, kFar) == greatest);
    CHECK(tree.farthest(queries, greatest / 2) > greatest / 2);
  }
}

// Borders are given as faces that repeat an end. Ends in decimals leave a rounding of a height, even along an axis.
void a_segment_holds_its_own_points() {
  std::mt19937_64 generator(7);
  std::uniform_int_distribution<int> thousandths(-9999, 9999);
  const auto coordinate = [&] { return thousandths(generator) / 1000.0; };
  for (int round = 0; round < 20000; ++round) {
    const Vec3 a{coordinate(), coordinate(), coordinate()};
    Vec3 b{coordinate(), coordinate(), coordinate()};
    if (round % 2) b.x = a.x, b.z = a.z;
    if (length(b - a) < 0.1) continue;
    for (const FramedTriangle& segment : {FramedTriangle(a, b, b), FramedTriangle(a, a, b), FramedTriangle(b, a, b)}) {
      CHECK(segment.height == 0 || std::abs(dot(segment.x, segment.y)) < 1e-15);
      for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        const Vec3 point = a + share * (b - a);
        CHECK(segment.within(point, 1e-12));
        CHECK(segment.squared_distance(point) < 1e-26);
      }
    }
  }
}

void without_faces_everything_is_far() {
  const std::vector<Vec3> queries(3, Vec3{0, 0, 0});
  const FaceTree tree({}, {});
  CHECK(tree.distances(queries) == std::vector<double>(3, kFar));
  CHECK(tree.farthest(queries, 1.0) == kFar);
  CHECK(tree.farthest({}, 1.0) == 0.0);
}

// A rough field with holes and a step, seen by triangles of many sizes.
void panels_hold_what_is_near_and_nothing_else() {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> rough(-0.1, 0.1), place(0, 40), high(-0.5, 0.5);
  constexpr Index n = 40;
  std::vector<Vec3> points;
  std::vector<Face> faces;
  for (Index i = 0; i <= n; ++i)
    for (Index j = 0; j <= n; ++j)
      points.push_back({static_cast<double>(i), static_cast<double>(j), (j > 25 ? 0.5 : 0.0) + rough(generator)});
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j) {
      if (i % 13 == 7 && j % 11 == 5) continue;
      const Index a = i * (n + 1) + j, b = a + n + 1;
      faces.insert(faces.end(), {{a, b, b + 1}, {a, b + 1, a + 1}});
    }
  const double limit = 0.3;
  const FaceTree plain(points, faces), with(points, faces, limit);
  int held = 0;
  for (int round = 0; round < 3000; ++round) {
    const double size = 0.5 + round % 10, x = place(generator), y = place(generator), z = high(generator);
    const Triangle t{Vec3{x, y, z}, Vec3{x + size, y, z}, Vec3{x, y + size, z + 0.2 * rough(generator)}};
    const bool found = Certificate(with).holds(t, limit);
    held += found;
    CHECK(found || !Certificate(plain).holds(t, limit));
    if (found) CHECK(Certificate(plain).bound(t, limit, 1e-3) <= limit + 2e-3);
  }
  CHECK(held > 100);
}

}  // namespace

int main() {
  RUN(a_segment_holds_its_own_points);
  RUN(the_tree_finds_the_nearest_of_all_faces);
  RUN(panels_hold_what_is_near_and_nothing_else);
  RUN(without_faces_everything_is_far);
  return check::report();
}
