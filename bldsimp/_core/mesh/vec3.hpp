// Points and vectors of space, and the few operations that the mesh kernels need.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "mesh/predicates.hpp"

namespace bldsimp {

using Index = std::int32_t;
using Face = std::array<Index, 3>;
using IndexPair = std::array<Index, 2>;
using Edge = IndexPair;
using Vec3 = Point3;
using Triangle = std::array<Vec3, 3>;

inline bool operator==(Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(Vec3 a) { return std::sqrt(dot(a, a)); }

inline bool lexicographic_less(Vec3 a, Vec3 b) {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

// Distance of p to the segment a-b (to the point a where both ends are equal).
inline double segment_distance(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 d = b - a;
  const double dd = dot(d, d);
  double t = dd > 0 ? dot(p - a, d) / dd : 0.0;
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  return length(p - (a + t * d));
}

// Halfedge h belongs to face h / 3, starts at corner h % 3 and ends at the next corner.
inline Index next_halfedge(Index h) { return h % 3 == 2 ? h - 2 : h + 1; }
inline Index previous_halfedge(Index h) { return h % 3 == 0 ? h + 2 : h - 1; }

}  // namespace bldsimp
