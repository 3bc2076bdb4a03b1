#include "mesh/predicates.hpp"

#include <initializer_list>

#include "mesh/bigint.hpp"
#include "mesh/double_word.hpp"
#include "mesh/expansion.hpp"

namespace bldsimp::exact {
namespace {

// Within these magnitudes a difference has no bit below 2^-252, so that a product of four has none
// below 2^-1008, and nothing exceeds 2^804 + a few bits.
bool expansions_hold(std::initializer_list<double> coordinates) {
  return std::all_of(coordinates.begin(), coordinates.end(), [](double value) {
    const double magnitude = std::abs(value);
    return magnitude == 0.0 || (magnitude >= 0x1p-200 && magnitude <= 0x1p200);
  });
}

// The exponent at which all of the coordinates are whole numbers.
int common_exponent(std::initializer_list<double> coordinates) {
  int least = 1024;
  for (const double value : coordinates) {
    if (value == 0.0) continue;
    int power;
    std::frexp(value, &power);
    least = std::min(least, std::max(power - 53, -1074));
  }
  return least;
}

// Differences as expansions; a type of its own, so that calls are inlined.
struct Exactly {
  Expansion<2> operator()(double a, double b) const { return difference(a, b); }
};

struct InTwoWords {
  DoubleWord operator()(double a, double b) const {
    double rest;
    const double value = two_sum(a, -b, rest);
    return {value, rest};
  }
};

// Sums of at most three products of differences, four deep, are off by at most 33 u^2 of their
// permanent: 10 u^2 for a minor and for a square, 27 u^2 for their product, 6 u^2 for the sums.
constexpr double double_word_bound = 64.0 * filter::unit * filter::unit;

template <class Number>
auto determinant(const Number& a, const Number& b, const Number& c, const Number& d) {
  return a * d - b * c;
}

template <class Difference>
int orient2d_by(const Point2& a, const Point2& b, const Point2& c, const Difference& minus) {
  return determinant(minus(a.x, c.x), minus(a.y, c.y), minus(b.x, c.x), minus(b.y, c.y)).sign();
}

template <class Difference>
auto incircle_determinant(const Point2& a, const Point2& b, const Point2& c, const Point2& d, const Difference& minus) {
  const auto ax = minus(a.x, d.x), ay = minus(a.y, d.y);
  const auto bx = minus(b.x, d.x), by = minus(b.y, d.y);
  const auto cx = minus(c.x, d.x), cy = minus(c.y, d.y);
  const auto of_a = (ax * ax + ay * ay) * determinant(bx, by, cx, cy);
  const auto of_b = (bx * bx + by * by) * determinant(cx, cy, ax, ay);
  const auto of_c = (cx * cx + cy * cy) * determinant(ax, ay, bx, by);
  return of_a + of_b + of_c;
}

template <class Difference>
auto orient3d_determinant(const Point3& a, const Point3& b, const Point3& c, const Point3& d, const Difference& minus) {
  const auto ax = minus(a.x, d.x), ay = minus(a.y, d.y), az = minus(a.z, d.z);
  const auto bx = minus(b.x, d.x), by = minus(b.y, d.y), bz = minus(b.z, d.z);
  const auto cx = minus(c.x, d.x), cy = minus(c.y, d.y), cz = minus(c.z, d.z);
  return az * determinant(bx, by, cx, cy) + bz * determinant(cx, cy, ax, ay) + cz * determinant(ax, ay, bx, by);
}

// The determinants with every product taken as positive, which bounds their rounding errors.
double incircle_permanent(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const double ax = a.x - d.x, ay = a.y - d.y, bx = b.x - d.x, by = b.y - d.y, cx = c.x - d.x, cy = c.y - d.y;
  return (std::abs(bx * cy) + std::abs(cx * by)) * (ax * ax + ay * ay) +
         (std::abs(cx * ay) + std::abs(ax * cy)) * (bx * bx + by * by) +
         (std::abs(ax * by) + std::abs(bx * ay)) * (cx * cx + cy * cy);
}

double orient3d_permanent(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const double ax = a.x - d.x, ay = a.y - d.y, bx = b.x - d.x, by = b.y - d.y, cx = c.x - d.x, cy = c.y - d.y;
  return (std::abs(bx * cy) + std::abs(cx * by)) * std::abs(a.z - d.z) +
         (std::abs(cx * ay) + std::abs(ax * cy)) * std::abs(b.z - d.z) +
         (std::abs(ax * by) + std::abs(bx * ay)) * std::abs(c.z - d.z);
}

// Whether c and d are the corners that make a-b a diagonal of a rectangle parallel to the axes.
bool rectangle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  return (c.x == a.x && c.y == b.y && d.x == b.x && d.y == a.y) ||
         (d.x == a.x && d.y == b.y && c.x == b.x && c.y == a.y);
}

// Differences as whole numbers, in units of which every coordinate has a whole number.
auto bigint_difference(std::initializer_list<double> coordinates) {
  return [exponent = common_exponent(coordinates)](double a, double b) {
    return BigInt(a, exponent) - BigInt(b, exponent);
  };
}

}  // namespace

int orient2d(const Point2& a, const Point2& b, const Point2& c) {
  // Three points on a line parallel to an axis are so common in buildings that this test pays.
  if ((a.x == c.x && b.x == c.x) || (a.y == c.y && b.y == c.y)) return 0;
  const auto coordinates = {a.x, a.y, b.x, b.y, c.x, c.y};
  if (expansions_hold(coordinates)) return orient2d_by(a, b, c, Exactly{});
  return orient2d_by(a, b, c, bigint_difference(coordinates));
}

int incircle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  // Rectangles are as common: a grid of 90,000 points takes 37 ms instead of 52.
  if (rectangle(a, b, c, d) || rectangle(b, c, a, d) || rectangle(c, a, b, d)) return 0;
  const auto coordinates = {a.x, a.y, b.x, b.y, c.x, c.y, d.x, d.y};
  if (!expansions_hold(coordinates)) return incircle_determinant(a, b, c, d, bigint_difference(coordinates)).sign();
  const double value = incircle_determinant(a, b, c, d, InTwoWords{}).high;
  const double bound = double_word_bound * incircle_permanent(a, b, c, d);
  if (std::abs(value) > bound) return value > 0.0 ? 1 : -1;
  return incircle_determinant(a, b, c, d, Exactly{}).sign();
}

int orient3d(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  if ((a.x == d.x && b.x == d.x && c.x == d.x) || (a.y == d.y && b.y == d.y && c.y == d.y) ||
      (a.z == d.z && b.z == d.z && c.z == d.z))
    return 0;
  const auto coordinates = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z};
  if (!expansions_hold(coordinates)) return orient3d_determinant(a, b, c, d, bigint_difference(coordinates)).sign();
  const double value = orient3d_determinant(a, b, c, d, InTwoWords{}).high;
  const double bound = double_word_bound * orient3d_permanent(a, b, c, d);
  if (std::abs(value) > bound) return value > 0.0 ? 1 : -1;
  return orient3d_determinant(a, b, c, d, Exactly{}).sign();
}

double area2(const Point2& a, const Point2& b, const Point2& c) {
  if (!expansions_hold({a.x, a.y, b.x, b.y, c.x, c.y})) return (a.x - c.x) * (b.y - c.y) - (a.y - c.y) * (b.x - c.x);
  return determinant(difference(a.x, c.x), difference(a.y, c.y), difference(b.x, c.x), difference(b.y, c.y)).estimate();
}

}  // namespace bldsimp::exact
