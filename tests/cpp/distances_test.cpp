// The tree of boxes beside a search through all faces, in one thread and in several.
#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "check.hpp"
#include "distances.hpp"

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

void without_faces_everything_is_far() {
  const std::vector<Vec3> queries(3, Vec3{0, 0, 0});
  const FaceTree tree({}, {});
  CHECK(tree.distances(queries) == std::vector<double>(3, kFar));
  CHECK(tree.farthest(queries, 1.0) == kFar);
  CHECK(tree.farthest({}, 1.0) == 0.0);
}

// A triangle over two that part along its other diagonal: many times longer than the precision that is asked for.
void reach_is_never_too_small_and_near_however_long_the_triangle() {
  const double length = 30;
  for (const double bend : {0.0, 0.01, 1.0}) {
    const std::vector<Vec3> points{{0, 0, 0}, {length, 0, 0}, {length, 1, bend}, {0, 1, 0}};
    const FaceTree tree(points, std::vector<Face>{{0, 1, 3}, {1, 2, 3}});
    for (const double precision : {1e-1, 1e-3, 1e-5}) {
      double farthest = 0;
      Index nearest = 0;
      for (int i = 0; i <= 1000; ++i)
        farthest = std::max(farthest, tree.distance((i / 1000.0) * points[2], nearest));
      const double reach = tree.reach({points[0], points[1], points[2]}, 0, precision);
      CHECK(farthest <= reach + 1e-12);
      CHECK(reach <= farthest + std::max(precision, length / 10000));
      CHECK(tree.reach({points[0], points[1], points[2]}, farthest + 1, 0) <= farthest + 1);
    }
  }
}

}  // namespace

int main() {
  RUN(reach_is_never_too_small_and_near_however_long_the_triangle);
  RUN(the_tree_finds_the_nearest_of_all_faces);
  RUN(without_faces_everything_is_far);
  return check::report();
}
