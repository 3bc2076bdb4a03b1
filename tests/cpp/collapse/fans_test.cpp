// How far apart two fans are, beside places on the one and the other as a tree.
#include <cmath>
#include <random>
#include <vector>

#include "check.hpp"
#include "collapse/fans.hpp"
#include "mesh/distances.hpp"

using namespace bldsimp;

namespace {

using Ring = std::vector<std::array<Vec3, 2>>;

Ring ring_of(std::mt19937_64& generator, int count) {
  std::uniform_real_distribution<double> far(0.5, 1.5), high(-0.3, 0.3);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * 3.14159265 * i / count, size = far(generator);
    points.push_back({size * std::cos(angle), size * std::sin(angle), high(generator)});
  }
  Ring ring;
  for (int i = 0; i < count; ++i) ring.push_back({points[i], points[(i + 1) % count]});
  return ring;
}

// The greatest distance from places of the fan around `to` to the one around `from`.
double seen_apart(Vec3 from, Vec3 to, const Ring& ring) {
  std::vector<Vec3> points{from}, places;
  std::vector<Face> faces;
  for (const auto& [p, q] : ring) {
    const auto at = static_cast<Index>(points.size());
    points.insert(points.end(), {p, q});
    faces.push_back({0, at, at + 1});
    for (int i = 0; i <= 20; ++i)
      for (int j = 0; i + j <= 20; ++j) places.push_back(to + (i / 20.0) * (p - to) + (j / 20.0) * (q - to));
  }
  return FaceTree(points, faces).farthest(places, 1e300);
}

void fans_are_never_farther_apart_than_told() {
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> shift(-0.4, 0.4);
  int told = 0;
  for (int count = 3; count < 12; ++count)
    for (int round = 0; round < 40; ++round) {
      const Ring ring = ring_of(generator, count);
      const Vec3 from{shift(generator), shift(generator), shift(generator)};
      const bool moves = round % 2 == 0;
      const Vec3 to = moves ? Vec3{shift(generator), shift(generator), shift(generator)} : ring[0][0];
      const double apart = bound_fan_distance(from, to, ring);
      if (!std::isfinite(apart)) continue;
      ++told;
      CHECK(seen_apart(from, to, ring) <= apart + 1e-12);
    }
  CHECK(told > 100);
}

void a_fan_that_folds_or_winds_twice_tells_nothing() {
  const Ring square{
      {{{1, 0, 0}, {0, 1, 0}}}, {{{0, 1, 0}, {-1, 0, 0}}}, {{{-1, 0, 0}, {0, -1, 0}}}, {{{0, -1, 0}, {1, 0, 0}}}};
  CHECK(bound_fan_distance({0, 0, 0.1}, {0.1, 0, 0}, square) < 0.2);
  CHECK(std::isinf(bound_fan_distance({0, 0, 0}, {2, 0, 0}, square)));
  CHECK(std::isinf(bound_fan_distance({2, 0, 0}, {0, 0, 0}, square)));
  Ring twice = square;
  twice.insert(twice.end(), square.begin(), square.end());
  CHECK(std::isinf(bound_fan_distance({0, 0, 0.1}, {0.1, 0, 0}, twice)));
}

}  // namespace

int main() {
  RUN(fans_are_never_farther_apart_than_told);
  RUN(a_fan_that_folds_or_winds_twice_tells_nothing);
  return check::report();
}
