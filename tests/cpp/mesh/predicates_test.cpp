// Predicates: filters, expansions and whole numbers of any length agree; poles are never wrong.
#include "mesh/predicates.hpp"

#include <cmath>
#include <random>
#include <vector>

#include "cdt/hilbert.hpp"
#include "check.hpp"
#include "mesh/bigint.hpp"
#include "mesh/expansion.hpp"

using namespace bldsimp;

namespace {

std::mt19937_64 generator(3);

// Nearly collinear and cocircular: small whole numbers, or those off by units in the last place.
double coordinate() {
  const auto whole = static_cast<double>(1 + generator() % 8);
  return generator() % 3 == 0 ? std::nextafter(whole, 9.0) : whole;
}
Point2 point() { return {coordinate(), coordinate()}; }
Point3 point3() { return {coordinate(), coordinate(), coordinate()}; }
Point2 scaled(const Point2& p, int power) { return {std::ldexp(p.x, power), std::ldexp(p.y, power)}; }
Point3 scaled(const Point3& p, int power) {
  return {std::ldexp(p.x, power), std::ldexp(p.y, power), std::ldexp(p.z, power)};
}

// Scaled by 2^power, coordinates leave the range of expansions, and whole numbers take over.
void expansions_agree_with_whole_numbers() {
  for (int i = 0; i < 20000; ++i) {
    const int power = i % 2 == 0 ? 900 : -900;
    const Point2 a = point(), b = point(), c = point(), d = point();
    CHECK(orient2d(a, b, c) == orient2d(scaled(a, power), scaled(b, power), scaled(c, power)));
    CHECK(incircle(a, b, c, d) == incircle(scaled(a, power), scaled(b, power), scaled(c, power), scaled(d, power)));
    const Point3 p = point3(), q = point3(), r = point3(), s = point3();
    CHECK(orient3d(p, q, r, s) == orient3d(scaled(p, power), scaled(q, power), scaled(r, power), scaled(s, power)));
  }
}

void filters_agree_with_expansions() {
  for (int i = 0; i < 20000; ++i) {
    const Point2 a = point(), b = point(), c = point(), d = point();
    CHECK(orient2d(a, b, c) == exact::orient2d(a, b, c));
    CHECK(incircle(a, b, c, d) == exact::incircle(a, b, c, d));
    const Point3 p = point3(), q = point3(), r = point3(), s = point3();
    CHECK(orient3d(p, q, r, s) == exact::orient3d(p, q, r, s));
  }
}

void signs_follow_their_arguments() {
  for (int i = 0; i < 5000; ++i) {
    const Point2 a = point(), b = point(), c = point(), d = point();
    CHECK(orient2d(a, b, c) == orient2d(b, c, a));
    CHECK(orient2d(a, b, c) == -orient2d(b, a, c));
    CHECK(incircle(a, b, c, d) == incircle(b, c, a, d));
    CHECK(incircle(a, b, c, d) == -incircle(a, b, d, c));
  }
}

void poles_are_never_wrong() {
  for (int i = 0; i < 20000; ++i) {
    const Point2 a = point(), b = point(), c = point();
    const int told = direction_by_poles(a, b, c);
    CHECK(told == 0 || told == orient2d(a, b, c));
  }
  CHECK(direction_by_poles({0, 0}, {1, 0}, {0, 1}) == 1);
  CHECK(direction_by_poles({0, 0}, {0, 1}, {1, 0}) == -1);
  CHECK(direction_by_poles({0, 0}, {2, 2}, {1, 1}) == 0);
  CHECK(direction_by_poles({0, 0}, {0, 0}, {1, 1}) == 0);
}

void extremes() {
  const double most = 1.7976931348623157e308, least = 5e-324;
  CHECK(orient2d({-most, -most}, {most, -most}, {0, most}) == 1);
  CHECK(orient2d({0, 0}, {least, 0}, {0, least}) == 1);
  CHECK(orient2d({-most, -most}, {most, most}, {least, 0}) == -1);
  CHECK(incircle({-most, 0}, {most, 0}, {0, most}, {0, -most}) == 0);
  CHECK(incircle({-most, 0}, {most, 0}, {0, most}, {0, least}) == 1);
}

void sums_of_expansions_are_exact() {
  const auto third = difference(1.0, 1e-30);
  CHECK(third.size == 2);
  CHECK((third * third - third * third).size == 0);
  CHECK((third + third).estimate() == 2.0);
  CHECK((BigInt(1.0, -1074) - BigInt(5e-324, -1074)).sign() == 1);
  CHECK((BigInt(-3.0, -10) * BigInt(2.0, -10) + BigInt(6.0, -20)).sign() == 0);
}

// On a full grid of cells every step of the curve goes to a cell beside the last.
void curve_is_continuous() {
  std::vector<Point2> grid;
  for (int x = 0; x < 64; ++x)
    for (int y = 0; y < 64; ++y) grid.push_back({x + 0.5, y + 0.5});
  grid.push_back({0, 0});
  grid.push_back({64, 64});
  HilbertOrder workspace;
  const auto order = workspace.along_curve(grid);
  std::vector<Point2> sequence;
  for (const Index i : order)
    if (i < 64 * 64) sequence.push_back(grid[i]);
  CHECK(sequence.size() == 64 * 64);
  for (std::size_t i = 1; i < sequence.size(); ++i)
    CHECK(std::abs(sequence[i].x - sequence[i - 1].x) + std::abs(sequence[i].y - sequence[i - 1].y) == 1.0);
}

// A cluster far smaller than a cell of the whole is ordered within itself.
void curve_enters_clusters() {
  std::vector<Point2> points{{0, 0}, {1, 1}};
  for (int i = 0; i < 500; ++i)
    points.push_back({0.5 + static_cast<double>(generator() % 512) * 0x1p-50,
                      0.5 + static_cast<double>(generator() % 512) * 0x1p-50});
  HilbertOrder workspace;
  const auto order = workspace.along_curve(points);
  double way = 0.0;
  for (std::size_t i = 1; i < order.size(); ++i)
    if (order[i] > 1 && order[i - 1] > 1)
      way += std::hypot(points[order[i]].x - points[order[i - 1]].x, points[order[i]].y - points[order[i - 1]].y);
  CHECK(way < 500 * 64 * 0x1p-50);
}

}  // namespace

int main() {
  RUN(expansions_agree_with_whole_numbers);
  RUN(filters_agree_with_expansions);
  RUN(signs_follow_their_arguments);
  RUN(poles_are_never_wrong);
  RUN(extremes);
  RUN(sums_of_expansions_are_exact);
  RUN(curve_is_continuous);
  RUN(curve_enters_clusters);
  return check::report();
}
