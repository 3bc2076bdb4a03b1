#include "predicates.hpp"

#include <algorithm>
#include <initializer_list>

#include "expansion.hpp"
#include "wide.hpp"

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

template <class Number>
auto determinant(const Number& a, const Number& b, const Number& c, const Number& d) {
  return a * d - b * c;
}

template <class Difference>
int orient2d_by(const Point2& a, const Point2& b, const Point2& c, const Difference& minus) {
  return determinant(minus(a.x, c.x), minus(a.y, c.y), minus(b.x, c.x), minus(b.y, c.y)).sign();
}

template <class Difference>
int incircle_by(const Point2& a, const Point2& b, const Point2& c, const Point2& d, const Difference& minus) {
  const auto ax = minus(a.x, d.x), ay = minus(a.y, d.y);
  const auto bx = minus(b.x, d.x), by = minus(b.y, d.y);
  const auto cx = minus(c.x, d.x), cy = minus(c.y, d.y);
  const auto of_a = (ax * ax + ay * ay) * determinant(bx, by, cx, cy);
  const auto of_b = (bx * bx + by * by) * determinant(cx, cy, ax, ay);
  const auto of_c = (cx * cx + cy * cy) * determinant(ax, ay, bx, by);
  return (of_a + of_b + of_c).sign();
}

template <class Difference>
int orient3d_by(const Point3& a, const Point3& b, const Point3& c, const Point3& d, const Difference& minus) {
  const auto ax = minus(a.x, d.x), ay = minus(a.y, d.y), az = minus(a.z, d.z);
  const auto bx = minus(b.x, d.x), by = minus(b.y, d.y), bz = minus(b.z, d.z);
  const auto cx = minus(c.x, d.x), cy = minus(c.y, d.y), cz = minus(c.z, d.z);
  return (az * determinant(bx, by, cx, cy) + bz * determinant(cx, cy, ax, ay) +
          cz * determinant(ax, ay, bx, by))
      .sign();
}

template <class Use>
int exactly(std::initializer_list<double> coordinates, const Use& use) {
  if (expansions_hold(coordinates)) return use([](double a, double b) { return difference(a, b); });
  const int exponent = common_exponent(coordinates);
  return use([exponent](double a, double b) { return Wide(a, exponent) - Wide(b, exponent); });
}

}  // namespace

int orient2d(const Point2& a, const Point2& b, const Point2& c) {
  // Three points on a line parallel to an axis are so common in buildings that this test pays.
  if ((a.x == c.x && b.x == c.x) || (a.y == c.y && b.y == c.y)) return 0;
  return exactly({a.x, a.y, b.x, b.y, c.x, c.y},
                 [&](const auto& minus) { return orient2d_by(a, b, c, minus); });
}

int incircle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  return exactly({a.x, a.y, b.x, b.y, c.x, c.y, d.x, d.y},
                 [&](const auto& minus) { return incircle_by(a, b, c, d, minus); });
}

int orient3d(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  if ((a.x == d.x && b.x == d.x && c.x == d.x) || (a.y == d.y && b.y == d.y && c.y == d.y) ||
      (a.z == d.z && b.z == d.z && c.z == d.z))
    return 0;
  return exactly({a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z},
                 [&](const auto& minus) { return orient3d_by(a, b, c, d, minus); });
}

double area2(const Point2& a, const Point2& b, const Point2& c) {
  if (!expansions_hold({a.x, a.y, b.x, b.y, c.x, c.y}))
    return (a.x - c.x) * (b.y - c.y) - (a.y - c.y) * (b.x - c.x);
  return determinant(difference(a.x, c.x), difference(a.y, c.y), difference(b.x, c.x), difference(b.y, c.y))
      .estimate();
}

}  // namespace bldsimp::exact
