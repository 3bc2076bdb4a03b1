#include "farthest.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "box_tree.hpp"

namespace bldsimp {
namespace {

// Distance to a triangle; one without area is its edges.
double face_distance(Vec3 p, Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 normal = cross(b - a, c - a);
  const double area = length(normal);
  if (area > 0) {
    const bool inside = dot(cross(b - a, p - a), normal) >= 0 && dot(cross(c - b, p - b), normal) >= 0 &&
                        dot(cross(a - c, p - c), normal) >= 0;
    if (inside) return std::abs(dot(p - a, normal)) / area;
  }
  return std::min({segment_distance(p, a, b), segment_distance(p, b, c), segment_distance(p, c, a)});
}

double to_face(Vec3 p, std::span<const Vec3> points, const Face& face) {
  return face_distance(p, points[face[0]], points[face[1]], points[face[2]]);
}

}  // namespace

double farthest(std::span<const Vec3> queries, std::span<const Vec3> points, std::span<const Face> faces,
                double limit) {
  std::vector<Index> all(faces.size());
  std::iota(all.begin(), all.end(), 0);
  const BoxTree tree(points, faces, std::move(all));
  double greatest = 0;
  Index nearest = 0;  // neighbours in the input are near each other: a good first guess
  for (const Vec3 p : queries) {
    double best = to_face(p, points, faces[nearest]);
    tree.visit(p, [&](const Box& box) { return box.distance(p) < best; }, [&](Index f) {
      if (const double d = to_face(p, points, faces[f]); d < best) {
        best = d;
        nearest = f;
      }
    });
    greatest = std::max(greatest, best);
    if (greatest > limit) break;
  }
  return greatest;
}

}  // namespace bldsimp
