// Put a triangle into a frame of its own, for exact distances to it.
#pragma once

#include <limits>
#include <tuple>

#include "mesh/vec3.hpp"

namespace bldsimp {

// The longest side runs from `origin` along `x`, the corner opposite lies at (foot, height), and both angles at
// the longest side are acute. A triangle without area is its longest side, or its point.
struct FramedTriangle {
  FramedTriangle(Vec3 a, Vec3 b, Vec3 c);
  double squared_distance(Vec3 p) const;
  bool within(Vec3 p, double limit) const;  // most that are not are told without a division
  // Whether a point within the limit is above or below rather than beside: there its way to the outline counts double.
  // True of all between some points where it is true of those.
  bool lies_under(Vec3 p, double limit) const;
  // Whether it is within 45 degrees of square to a normal; false without an area.
  bool is_across(Vec3 way) const { return std::abs(dot(normal(), way)) >= cosine_across; }

  Vec3 normal() const { return cross(x, y); }  // zero without an area

  // Cosine of 45 degrees, rounded down.
  static constexpr double cosine_across = 0.7071067;

  // Share of its longest side below which the height of a triangle is a rounding.
  static constexpr double no_height = 4e-16;

  Vec3 origin, x{0, 0, 0}, y{0, 0, 0};
  double length, foot = 0, height = 0;
};

// Squared distance of (x, y) to the segment from the origin to (u, v), of which one is not 0.
inline double squared_segment_distance(double x, double y, double u, double v) {
  const double t = std::clamp((x * u + y * v) / (u * u + v * v), 0.0, 1.0);
  return (x - t * u) * (x - t * u) + (y - t * v) * (y - t * v);
}

// Directions are unit vectors made square to each other, so that the triangle in its frame is the one
// stored but for a few roundings, however thin it is.
inline FramedTriangle::FramedTriangle(Vec3 a, Vec3 b, Vec3 c) {
  const double ab = bldsimp::length(b - a), bc = bldsimp::length(c - b), ca = bldsimp::length(a - c);
  if (bc > ab && bc >= ca)
    std::tie(a, b, c) = std::tuple(b, c, a);
  else if (ca > ab)
    std::tie(a, b, c) = std::tuple(c, a, b);
  origin = a;
  length = bldsimp::length(b - a);
  if (length == 0) return;
  x = (1 / length) * (b - a);
  const Vec3 side = c - a;
  foot = dot(side, x);
  Vec3 up = side - foot * x;
  up = up - dot(up, x) * x;
  height = bldsimp::length(up);
  // A height that is a mere rounding says nothing of a direction: `y` along it need not be square to `x`, and `within`
  // would refuse points of the longest side itself.
  if (height > no_height * length)
    y = (1 / height) * up;
  else
    height = 0;
}

inline double FramedTriangle::squared_distance(Vec3 p) const {
  const Vec3 way = p - origin;
  const double u = dot(way, x);
  const Vec3 rest = way - u * x;
  const double v = dot(rest, y);
  const Vec3 out = rest - v * y;
  const double across = dot(out, out);
  if (v <= 0) {
    const double beyond = u - std::clamp(u, 0.0, length);
    return across + v * v + beyond * beyond;
  }
  const bool left = foot * v > height * u, right = (length - foot) * v > height * (length - u);
  double within = left || right ? std::numeric_limits<double>::infinity() : 0.0;
  if (left) within = squared_segment_distance(u, v, foot, height);
  if (right) within = std::min(within, squared_segment_distance(u - length, v, foot - length, height));
  return across + within;
}

inline bool FramedTriangle::within(Vec3 p, double limit) const {
  const Vec3 way = p - origin;
  const double u = dot(way, x);
  if (u < -limit || u > length + limit) return false;
  const double v = dot(way, y);
  if (v < -limit || v > height + limit) return false;
  return squared_distance(p) <= limit * limit;
}

inline bool FramedTriangle::lies_under(Vec3 p, double limit) const {
  if (!within(p, limit)) return false;
  const double height_of_p = dot(p - origin, cross(x, y)), up = height_of_p * height_of_p;
  return 4 * (squared_distance(p) - up) + up <= limit * limit;
}

// The longest side runs from this corner to the next.
inline std::size_t longest_at(const Triangle& t) {
  const std::array<double, 3> sides{length(t[1] - t[0]), length(t[2] - t[1]), length(t[0] - t[2])};
  return static_cast<std::size_t>(std::max_element(sides.begin(), sides.end()) - sides.begin());
}

inline double longest_side(const Triangle& t) {
  const std::size_t i = longest_at(t);
  return length(t[(i + 1) % 3] - t[i]);
}

// A triangle cut in two across the middle of its longest side.
inline std::array<Triangle, 2> halve(const Triangle& t) {
  const std::size_t i = longest_at(t);
  const Vec3 p = t[i], q = t[(i + 1) % 3], r = t[(i + 2) % 3], half = 0.5 * (p + q);
  return {{{p, half, r}, {half, q, r}}};
}

}  // namespace bldsimp
