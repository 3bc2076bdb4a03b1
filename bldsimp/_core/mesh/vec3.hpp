// Define points, vectors, faces and triangles of space, and the few operations that the kernels need.
#pragma once

#include "mesh/predicates.hpp"

namespace bldsimp {

using Face = std::array<Index, 3>;
using Edge = IndexPair;
using Vec3 = Point3;
using Triangle = std::array<Vec3, 3>;

// Views of arrays that others own.
using Points = std::span<const Vec3>;
using Faces = std::span<const Face>;

inline bool operator==(Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(Vec3 a) { return std::sqrt(dot(a, a)); }

// A vector of length 1, or zero.
inline Vec3 normalize(Vec3 v) {
  const double size = length(v);
  return size > 0 ? (1 / size) * v : Vec3{0, 0, 0};
}
// Some vector of length 1 that is square to one of length 1.
inline Vec3 square_to(Vec3 u) {
  const Vec3 side = cross(u, std::abs(u.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0});
  return (1 / length(side)) * side;
}

inline Triangle corners_of(const Face& f, Points points) { return {points[f[0]], points[f[1]], points[f[2]]}; }
// Points along the normal; as long as twice the area.
inline Vec3 area_vector(const Triangle& t) { return cross(t[1] - t[0], t[2] - t[0]); }
inline Vec3 centroid(const Triangle& t) { return (1.0 / 3) * (t[0] + t[1] + t[2]); }
inline bool has_corner(const Face& f, Index p) { return f[0] == p || f[1] == p || f[2] == p; }

// Points about one of them, so that differences round less.
inline std::vector<Vec3> about_middle(Points points) {
  const Vec3 middle = points.empty() ? Vec3{0, 0, 0} : points[points.size() / 2];
  std::vector<Vec3> moved;
  moved.reserve(points.size());
  for (const Vec3& p : points) moved.push_back(p - middle);
  return moved;
}

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
