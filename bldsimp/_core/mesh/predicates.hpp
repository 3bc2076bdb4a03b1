// Tell the side, the circle, the half-space of a point: exact signs for all finite doubles.
//
// A floating-point filter answers the plain cases; expansions answer the close ones; where
// coordinates are so large or small that expansions would overflow or underflow (magnitudes other
// than 0 outside 2^-200 .. 2^200), whole numbers of any length do. There is no epsilon.
// Precondition of all: finite coordinates. Complexity: O(1). Same result on every machine,
// provided that the compiler does not contract a*b+c (-ffp-contract=off).
// Source: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", 1997, whose error bounds the filters use.
#pragma once

#include "mesh/array.hpp"

namespace bldsimp {

struct Point2 {
  double x, y;
};

struct Point3 {
  double x, y, z;
};

inline bool operator==(const Point2& a, const Point2& b) { return a.x == b.x && a.y == b.y; }

// The order that breaks all ties: by x, then by y.
inline bool lexicographically_less(const Point2& a, const Point2& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }

namespace exact {
int orient2d(const Point2& a, const Point2& b, const Point2& c);
int incircle(const Point2& a, const Point2& b, const Point2& c, const Point2& d);
int orient3d(const Point3& a, const Point3& b, const Point3& c, const Point3& d);
// Twice the signed area of a, b, c, off by a few units in the last place; not finite where the
// coordinates are outside the range of expansions and the plain formula overflows.
double area2(const Point2& a, const Point2& b, const Point2& c);
}  // namespace exact

namespace filter {
inline constexpr double unit = 0x1p-53;  // half the spacing at 1
inline constexpr double orient2d = (3.0 + 16.0 * unit) * unit;
inline constexpr double incircle = (10.0 + 96.0 * unit) * unit;
inline constexpr double orient3d = (7.0 + 56.0 * unit) * unit;
// What underflow may add to the error, provided that no square is above `large`.
inline constexpr double floor2 = 0x1p-1000;
inline constexpr double floor4 = 0x1p-700;
inline constexpr double large = 0x1p300;
}  // namespace filter

// Direction of triangle a, b, c by its poles: > 0 counter-clockwise, < 0 clockwise, 0 where two
// vertices hold all four poles, so that they cannot tell. Comparisons only, hence exact.
// Left is the least x (ties: least y), bottom the least y (ties: greatest x), right the greatest x
// (ties: greatest y), top the greatest y (ties: least x): with ties, the counter-clockwise end of
// that side of the bounding box. If the three vertices all occur among them, the order of their
// first occurrence is the direction.
inline int direction_by_poles(const Point2& a, const Point2& b, const Point2& c) {
  if (a == b || b == c || c == a) return 0;
  const Point2* const vertex[3] = {&a, &b, &c};
  int left = 0, bottom = 0, right = 0, top = 0;
  for (int i = 1; i < 3; ++i) {
    const Point2& p = *vertex[i];
    const Point2 &l = *vertex[left], &lo = *vertex[bottom], &r = *vertex[right], &hi = *vertex[top];
    if (p.x < l.x || (p.x == l.x && p.y < l.y)) left = i;
    if (p.y < lo.y || (p.y == lo.y && p.x > lo.x)) bottom = i;
    if (p.x > r.x || (p.x == r.x && p.y > r.y)) right = i;
    if (p.y > hi.y || (p.y == hi.y && p.x < hi.x)) top = i;
  }
  const int first = left;
  const int second = bottom != first ? bottom : (right != first ? right : top);
  const int third = 3 - first - second;
  if (third != right && third != top) return 0;
  return second == (first + 1) % 3 ? 1 : -1;
}

// > 0 iff a, b, c turn counter-clockwise, 0 iff they are collinear.
inline int orient2d(const Point2& a, const Point2& b, const Point2& c) {
  const double left = (a.x - c.x) * (b.y - c.y);
  const double right = (a.y - c.y) * (b.x - c.x);
  const double determinant = left - right;
  const double bound = filter::orient2d * (std::abs(left) + std::abs(right)) + filter::floor2;
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  return exact::orient2d(a, b, c);
}

// > 0 iff d lies inside the circle through the counter-clockwise a, b, c, 0 iff on it.
inline int incircle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const double ax = a.x - d.x, ay = a.y - d.y;
  const double bx = b.x - d.x, by = b.y - d.y;
  const double cx = c.x - d.x, cy = c.y - d.y;
  const double bc1 = bx * cy, bc2 = cx * by;
  const double ca1 = cx * ay, ca2 = ax * cy;
  const double ab1 = ax * by, ab2 = bx * ay;
  const double a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
  const double determinant = a2 * (bc1 - bc2) + b2 * (ca1 - ca2) + c2 * (ab1 - ab2);
  const double permanent = (std::abs(bc1) + std::abs(bc2)) * a2 + (std::abs(ca1) + std::abs(ca2)) * b2 +
                           (std::abs(ab1) + std::abs(ab2)) * c2;
  const double bound = filter::incircle * permanent + filter::floor4;
  if (a2 + b2 + c2 < filter::large) {
    if (determinant > bound) return 1;
    if (determinant < -bound) return -1;
  }
  return exact::incircle(a, b, c, d);
}

// > 0 iff d lies below the plane through a, b, c, "below" being the side from which they turn
// clockwise (a, b, c counter-clockwise in x, y: below in z); 0 iff the four are coplanar.
inline int orient3d(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const double ax = a.x - d.x, ay = a.y - d.y, az = a.z - d.z;
  const double bx = b.x - d.x, by = b.y - d.y, bz = b.z - d.z;
  const double cx = c.x - d.x, cy = c.y - d.y, cz = c.z - d.z;
  const double bc1 = bx * cy, bc2 = cx * by;
  const double ca1 = cx * ay, ca2 = ax * cy;
  const double ab1 = ax * by, ab2 = bx * ay;
  const double determinant = az * (bc1 - bc2) + bz * (ca1 - ca2) + cz * (ab1 - ab2);
  const double permanent = (std::abs(bc1) + std::abs(bc2)) * std::abs(az) +
                           (std::abs(ca1) + std::abs(ca2)) * std::abs(bz) +
                           (std::abs(ab1) + std::abs(ab2)) * std::abs(cz);
  const double bound = filter::orient3d * permanent + filter::floor4;
  if (std::abs(az) + std::abs(bz) + std::abs(cz) < filter::large) {
    if (determinant > bound) return 1;
    if (determinant < -bound) return -1;
  }
  return exact::orient3d(a, b, c, d);
}

}  // namespace bldsimp
