// Certificates beside dense samples, and beside a branch and bound that shares no code with them.
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "check.hpp"
#include "mesh/certificate.hpp"
#include "mesh/parallel.hpp"
#include "shapes.hpp"

using namespace bldsimp;
using namespace shapes;

namespace {

// What distances and cuts may be off by, as a share of the coordinates.
constexpr double kRounding = 1e-12;

// More digits than the kernels have: needles need them.
struct Long3 {
  long double x, y, z;
  explicit Long3(Vec3 p) : x(p.x), y(p.y), z(p.z) {}
  Long3(long double u, long double v, long double w) : x(u), y(v), z(w) {}
};
Long3 operator-(Long3 a, Long3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
long double dot(Long3 a, Long3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Long3 cross(Long3 a, Long3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

long double to_segment(Long3 p, Long3 a, Long3 b) {
  const Long3 d = b - a, way = p - a;
  const long double square = dot(d, d);
  const long double t = square > 0 ? std::clamp(dot(way, d) / square, 0.0L, 1.0L) : 0.0L;
  const Long3 off{way.x - t * d.x, way.y - t * d.y, way.z - t * d.z};
  return std::sqrt(dot(off, off));
}

// Distance to a triangle by its plane and its sides.
double to_triangle(Vec3 point, const Triangle& triangle) {
  const Long3 p(point), t[] = {Long3(triangle[0]), Long3(triangle[1]), Long3(triangle[2])};
  const long double least = std::min({to_segment(p, t[0], t[1]), to_segment(p, t[1], t[2]), to_segment(p, t[2], t[0])});
  const Long3 n = cross(t[1] - t[0], t[2] - t[0]);
  const long double size = std::sqrt(dot(n, n)), longest = longest_side(triangle);
  bool above = size > 1e-12L * longest * longest;
  for (int i = 0; i < 3; ++i) above = above && dot(cross(t[(i + 1) % 3] - t[i], p - t[i]), n) >= 0;
  return static_cast<double>(above ? std::min(least, std::abs(dot(p - t[0], n)) / size) : least);
}

double to_surface(Vec3 p, const Soup& surface) {
  double least = std::numeric_limits<double>::infinity();
  for (const Face& face : surface.faces) least = std::min(least, to_triangle(p, corners_of(face, surface.points)));
  return least;
}

struct Interval {
  double low, high;
};

// The greatest distance of a triangle, between two bounds that are `precision` apart if `most` pieces suffice.
Interval find_farthest(const Triangle& triangle, const Soup& surface, double precision, std::size_t most) {
  struct Part {
    double high;
    Triangle corners;
    bool operator<(const Part& o) const { return high < o.high; }
  };
  double low = 0;
  std::priority_queue<Part> parts;
  const auto push = [&](const Triangle& t) {
    const Vec3 middle = centroid(t);
    const double at = to_surface(middle, surface);
    low = std::max(low, at);
    double way = 0;
    for (const Vec3& p : t) way = std::max(way, length(p - middle));
    parts.push({at + way, t});
  };
  for (const Vec3& p : triangle) low = std::max(low, to_surface(p, surface));
  push(triangle);
  for (std::size_t i = 0; i < most && parts.top().high > low + precision; ++i) {
    const Triangle t = parts.top().corners;
    parts.pop();
    for (const Triangle& half : halve(t)) push(half);
  }
  return {low, std::max(low, parts.top().high)};
}

double sample(const Triangle& t, const Soup& surface, int steps) {
  double most = 0;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; i + j <= steps; ++j) {
      const double u = double(i) / steps, v = double(j) / steps;
      most = std::max(most, to_surface((1 - u - v) * t[0] + u * t[1] + v * t[2], surface));
    }
  return most;
}

Vec3 random_point(Random& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}

// Faces between any points: needles, segments and mere points among them, some on a coarse grid, where all is parallel,
// in one plane, or twice.
Soup random_soup(Random& random) {
  Soup soup;
  const bool coarse = random() % 2, flat = random() % 3 == 0;
  const Index count = 3 + below(random, 8);
  for (Index i = 0; i < count; ++i) {
    Vec3 p = random_point(random, 1);
    if (coarse) p = {std::round(2 * p.x) / 2, std::round(2 * p.y) / 2, std::round(2 * p.z) / 2};
    if (flat) p.z = random() % 2 ? 1e-3 * p.z : 0;
    soup.add(p);
  }
  for (Index i = 0; i < 1 + below(random, 12); ++i)
    soup.faces.push_back({below(random, count), below(random, count), below(random, count)});
  add_needles(random, soup, below(random, 3), random() % 2 ? 1e-7 : 0);
  return soup;
}

// A sheet, and near it a triangle that covers much of it.
Soup random_sheet(Random& random) { return noisy_sheet(random, 3 + below(random, 4), random() % 2 ? 0.05 : 0, 0.1); }

Triangle random_triangle(Random& random, const Soup& soup) {
  const auto corner = [&] {
    const Vec3 p = soup.points[static_cast<std::size_t>(below(random, static_cast<Index>(soup.points.size())))];
    const double off[] = {0, 0, 1e-12, 1e-6, 0.01, 0.3};
    return p + random_point(random, off[random() % 6]);
  };
  Triangle t{corner(), corner(), corner()};
  if (random() % 8 == 0) t[2] = t[1];
  if (random() % 8 == 0) t[2] = 0.5 * (t[0] + t[1]);
  return t;
}

template <class Test>
void try_many(Random& random, int rounds, Test test) {
  for (int round = 0; round < rounds; ++round) {
    Soup soup = random() % 2 ? random_soup(random) : random_sheet(random);
    rotate(soup, random() % 2 ? 0 : uniform(random, 0, 6));
    test(soup, random_triangle(random, soup));
  }
}

void a_bound_is_never_below_the_truth_and_as_near_as_asked() {
  Random random(1);
  int open = 0;
  try_many(random, 1000, [&](const Soup& soup, const Triangle& triangle) {
    const FaceTree tree(soup.points, soup.faces);
    Certificate certificate(tree);
    const auto [low, high] = find_farthest(triangle, soup, 1e-2, 500);
    open += high > low + 1e-2;
    for (const double precision : {1e-2, 1e-4}) {
      const double found =
          certificate.bound(triangle, 0, precision, below(random, static_cast<Index>(soup.faces.size())));
      CHECK(found >= low - kRounding);
      CHECK(found >= sample(triangle, soup, 12) - kRounding);
      CHECK(found <= high + precision + kRounding);
      CHECK(found == Certificate(tree).bound(triangle, 0, precision) || found <= low + 1e-2 + precision);
      const double enough = found + 0.1;
      CHECK(certificate.bound(triangle, enough, precision) <= enough);
    }
  });
  CHECK(open < 400);
}

void what_holds_is_within_the_limit_and_what_is_well_within_it_holds() {
  Random random(2);
  int held = 0, refused = 0;
  try_many(random, 1000, [&](const Soup& soup, const Triangle& triangle) {
    const FaceTree tree(soup.points, soup.faces);
    Certificate certificate(tree);
    const double top = certificate.bound(triangle, 0, 1e-4);
    for (const double share : {0.3, 0.9, 0.99, 1.01, 1.1, 2.0}) {
      const double limit = share * top + 1e-9;
      const bool holds = certificate.holds(triangle, limit, below(random, static_cast<Index>(soup.faces.size())));
      ++(holds ? held : refused);
      const double sampled = sample(triangle, soup, 12);
      if (holds) CHECK(sampled <= limit + kRounding);
      if (holds) CHECK(find_farthest(triangle, soup, 1e-2 * limit, 200).low <= limit + kRounding);
      if (top <= 0.95 * limit) CHECK(holds);
    }
  });
  CHECK(held > 1000);
  CHECK(refused > 1000);
}

// Two triangles over a rectangle, and two that part it along the other diagonal: however long it is, few cells.
void the_number_of_cells_follows_the_overlaps() {
  const double side = 30;
  for (const double bend : {0.0, 0.01, 1.0}) {
    const std::vector<Vec3> points{{0, 0, 0}, {side, 0, 0}, {side, 1, bend}, {0, 1, 0}};
    const FaceTree tree(points, std::vector<Face>{{0, 1, 3}, {1, 2, 3}});
    const Triangle triangle{points[0], points[1], points[2]};
    double farthest = 0;
    Index nearest = 0;
    for (int i = 0; i <= 1000; ++i) farthest = std::max(farthest, tree.distance((i / 1000.0) * points[2], nearest));
    for (const double precision : {1e-1, 1e-3, 1e-5, 1e-7}) {
      Certificate certificate(tree);
      const double found = certificate.bound(triangle, 0, precision);
      CHECK(farthest <= found + kRounding);
      CHECK(found <= farthest + precision + side * side * 1e-6);
      CHECK(certificate.cells() < 100);
      CHECK(certificate.bound(triangle, farthest + 1, 0) <= farthest + 1);
    }
  }
}

// Columns of different widths on both sides of one wall: as many cells as overlaps, whatever the limit.
void a_wall_in_other_columns_is_held_at_any_limit() {
  const auto wall = [](Index columns) {
    Soup soup;
    for (Index i = 0; i <= columns; ++i)
      for (const double z : {0.0, 10.0}) soup.add({100.0 * i / columns, 0.1 * std::sin(100.0 * i / columns), z});
    for (Index i = 0; i < columns; ++i) soup.add_quad(2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1);
    return soup;
  };
  const Soup coarse = wall(7), fine = wall(90);
  const FaceTree tree(coarse.points, coarse.faces);
  const double truth = bound_distance(fine.points, fine.faces, tree, {0, 1e-9}).distance;
  for (const double precision : {1e-2, 1e-4, 1e-6, 1e-8}) {
    const SurfaceBound found = bound_distance(fine.points, fine.faces, tree, {0, precision});
    CHECK(std::abs(found.distance - truth) <= precision + 1e-9);
    CHECK(found.cells < 8000);
  }
  for (const double share : {1e-9, 1e-6, 1e-3}) {
    CHECK(stays_within(fine.points, fine.faces, tree, (1 + share) * truth + 1e-9));
    CHECK(!stays_within(fine.points, fine.faces, tree, (1 - share) * truth - 1e-9));
  }
}

void cells_are_the_same_with_any_number_of_threads() {
  Random random(3);
  const Soup sheet = noisy_sheet(random, 40, 0.2, 0.02), other = noisy_sheet(random, 40, 0.1, 0.02);
  const FaceTree tree(other.points, other.faces);
  const auto found = bound_distance(sheet.points, sheet.faces, tree, {0, 1e-4});
  const std::size_t before = most_threads;
  for (const std::size_t threads : {1, 2, 5}) {
    most_threads = threads;
    const auto again = bound_distance(sheet.points, sheet.faces, tree, {0, 1e-4});
    CHECK(again.distance == found.distance);
    CHECK(again.cells == found.cells);
  }
  most_threads = before;
}

void parts_of_a_cell_keep_its_corners_and_its_area() {
  Random random(4);
  const auto area = [](const Cell& cell) {
    double sum = 0;
    for (int i = 2; i < cell.size(); ++i) sum += 0.5 * length(area_vector({cell[0], cell[i - 1], cell[i]}));
    return sum;
  };
  const auto has = [](const Cell& cell, Vec3 p) { return std::ranges::count(cell.corners(), p) > 0; };
  int cuts = 0;
  for (int round = 0; round < 3000; ++round) {
    Cell cell({random_point(random, 1), random_point(random, 1), random_point(random, 1)});
    for (int depth = 0; depth < 12; ++depth) {
      const auto face = [&] {
        return FramedTriangle(random_point(random, 1), random_point(random, 1), random_point(random, 1));
      };
      const FramedTriangle own = face(), other = face();
      const Vec3 worst = cell[below(random, cell.size())];
      const auto parts = cut_cell(cell, {worst, find_normal(cell, own), own, other}, random() % 4 ? 0 : 10);
      if (!parts) break;
      ++cuts;
      const auto& [rest, beyond] = *parts;
      CHECK(std::abs(area(rest) + area(beyond) - area(cell)) < 1e-12);
      CHECK(rest.size() >= 3 && beyond.size() >= 3);
      CHECK(rest.depth() == depth + 1 && beyond.depth() == depth + 1);
      CHECK(has(beyond, worst) || cell.size() > 5);
      for (const Vec3& p : cell.corners()) CHECK(has(rest, p) || has(beyond, p));
      cell = random() % 2 ? rest : beyond;
    }
  }
  CHECK(cuts > 20000);
}

void without_faces_nothing_holds() {
  const FaceTree tree({}, {});
  const Triangle triangle{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}};
  Certificate certificate(tree);
  CHECK(certificate.bound(triangle, 0, 1) == std::numeric_limits<double>::infinity());
  CHECK(!certificate.holds(triangle, 1e9));
  CHECK(bound_distance({}, {}, tree, {0.5, 1}).distance == 0.5);
}

}  // namespace

int main() {
  RUN(a_bound_is_never_below_the_truth_and_as_near_as_asked);
  RUN(what_holds_is_within_the_limit_and_what_is_well_within_it_holds);
  RUN(the_number_of_cells_follows_the_overlaps);
  RUN(a_wall_in_other_columns_is_held_at_any_limit);
  RUN(cells_are_the_same_with_any_number_of_threads);
  RUN(parts_of_a_cell_keep_its_corners_and_its_area);
  RUN(without_faces_nothing_holds);
  return check::report();
}
