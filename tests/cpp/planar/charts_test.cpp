// Charts: what random rows carry is on the map of its chart, within half of the limit either way.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "check.hpp"
#include "mesh/halfedges.hpp"
#include "planar/charts.hpp"

using namespace bldsimp;

namespace {

constexpr Index kSide = 12;

// A bumpy grid; values follow one of two maps left and right of the middle, with noise.
struct Grid {
  std::vector<Vec3> points;
  std::vector<Face> faces;
  std::vector<double> values;
};

Grid random_grid(std::mt19937_64& generator, double bump, double noise) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Grid grid;
  for (Index x = 0; x <= kSide; ++x)
    for (Index y = 0; y <= kSide; ++y) {
      grid.points.push_back({double(x), double(y), bump * unit(generator)});
      const double slope = 2 * x < kSide ? 1.0 : -2.0;
      grid.values.insert(grid.values.end(), {slope * x + noise * unit(generator), 0.5 * y});
    }
  const auto at = [](Index x, Index y) { return x * (kSide + 1) + y; };
  for (Index x = 0; x < kSide; ++x)
    for (Index y = 0; y < kSide; ++y) {
      grid.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      grid.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  return grid;
}

void charts_hold(std::mt19937_64& generator, double bump, double noise, double limit) {
  const Grid grid = random_grid(generator, bump, noise);
  std::vector<Index> rows_of_points(grid.points.size()), source(grid.faces.size());
  std::iota(rows_of_points.begin(), rows_of_points.end(), 0);
  std::iota(source.begin(), source.end(), 0);
  const CornerRows rows{grid.faces, rows_of_points, source, {}};
  const Halfedges halfedges = pair_halfedges(grid.points, grid.faces, rows, 0.0);
  const std::vector<Index> start{0, static_cast<Index>(grid.faces.size())}, part(grid.faces.size(), 0);
  const std::vector<double> steps{10, 10}, limits{limit, limit};
  const Charts found =
      find_charts(grid.points, grid.faces, halfedges, start, source, rows, part, {grid.values, steps, limits});
  CHECK(found.chart_of_face.size() == grid.faces.size());
  CHECK(found.maps.size() == 4 * found.spans.size());
  std::vector<int> size(found.spans.size() / 2, 0);
  for (const Index chart : found.chart_of_face) ++size[chart];
  for (std::size_t f = 0; f < grid.faces.size(); ++f)
    for (const Index p : grid.faces[f])
      for (std::size_t c = 0; c < 2; ++c) {
        const double* map = &found.maps[4 * (2 * found.chart_of_face[f] + c)];
        const Vec3 at = grid.points[p];
        const double off =
            10 * std::abs(map[0] * at.x + map[1] * at.y + map[2] * at.z + map[3] - grid.values[2 * p + c]);
        CHECK(2 * off <= limit + 1e-9);
        const double span = found.spans[2 * found.chart_of_face[f] + c];
        CHECK(size[found.chart_of_face[f]] > 1 ? off <= span + 1e-9 : span == 0);
      }
}

// Strips of a grid, each a group with a map of its own but for every seventh, which bends in the middle; so many faces
// that several threads share them.
void many_groups_are_numbered_as_few() {
  constexpr Index strips = 1000, length = 80;
  std::vector<Vec3> points;
  std::vector<Face> faces;
  std::vector<double> values;
  std::vector<Index> start{0};
  for (Index s = 0; s < strips; ++s) {
    const Index first = static_cast<Index>(points.size());
    for (Index x = 0; x <= length; ++x)
      for (Index y = 0; y < 2; ++y) {
        points.push_back({double(x), 2.0 * s + y, 0});
        values.push_back(s % 7 == 0 && 2 * x > length ? 5.0 : (s % 5 + 1) * x);
      }
    for (Index x = 0; x < length; ++x) {
      const Index a = first + 2 * x;
      faces.push_back({a, a + 2, a + 3});
      faces.push_back({a, a + 3, a + 1});
    }
    start.push_back(static_cast<Index>(faces.size()));
  }
  std::vector<Index> row(points.size()), order(faces.size());
  std::iota(row.begin(), row.end(), 0);
  std::iota(order.begin(), order.end(), 0);
  const CornerRows rows{faces, row, order, {}};
  const Halfedges halfedges = pair_halfedges(points, faces, rows, 0.0);
  const std::vector<Index> part(faces.size(), 0);
  const std::vector<double> steps{1}, limits{0.5};
  const auto of = [&](Index first, Index last) {
    std::vector<Index> some(start.begin() + first, start.begin() + last + 1);
    return find_charts(points, faces, halfedges, some, order, rows, part, {values, steps, limits});
  };
  const Charts all = of(0, strips);
  CHECK(faces.size() >= 4 * (std::size_t{1} << 15));
  CHECK(all.maps.size() == 4 * all.spans.size());
  Index before = 0;
  for (Index s = 0; s < strips; ++s) {
    const Charts alone = of(s, s + 1);
    for (Index f = start[s]; f < start[s + 1]; ++f) {
      const Index chart = all.chart_of_face[f], own = alone.chart_of_face[f];
      CHECK(chart == before + own);
      CHECK(std::equal(&all.maps[4 * chart], &all.maps[4 * chart] + 4, &alone.maps[4 * own]));
    }
    CHECK((alone.spans.size() > 1) == (s % 7 == 0));
    before += static_cast<Index>(alone.spans.size());
  }
}

void random_charts_hold() {
  std::mt19937_64 generator(1);
  for (const double bump : {0.0, 1e-3, 0.3})
    for (const double noise : {0.0, 1e-3, 0.1})
      for (const double limit : {0.0, 0.5, 4.0}) charts_hold(generator, bump, noise, limit);
}

}  // namespace

int main() {
  RUN(random_charts_hold);
  RUN(many_groups_are_numbered_as_few);
  return check::report();
}
