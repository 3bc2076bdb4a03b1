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

// Distances to the nearest of some faces.
class Surface {
 public:
  Surface(std::span<const Vec3> points, std::span<const Face> faces)
      : points_(points), faces_(faces), tree_(points, faces, all(faces.size())) {}

  double to_face(Vec3 p, Index face) const {
    const auto [a, b, c] = faces_[face];
    return face_distance(p, points_[a], points_[b], points_[c]);
  }

  // `nearest` is a first guess, and then the nearest face.
  double distance(Vec3 p, Index& nearest) const {
    double best = to_face(p, nearest);
    tree_.visit(p, [&](const Box& box) { return box.distance(p) < best; }, [&](Index f) {
      if (const double d = to_face(p, f); d < best) {
        best = d;
        nearest = f;
      }
    });
    return best;
  }

 private:
  static std::vector<Index> all(std::size_t count) {
    std::vector<Index> members(count);
    std::iota(members.begin(), members.end(), 0);
    return members;
  }

  std::span<const Vec3> points_;
  std::span<const Face> faces_;
  BoxTree tree_;
};

using Corners = std::array<Vec3, 3>;

// Halves of one face: far more than any but a made-up case needs. What is left then counts as it is.
constexpr int kMostHalves = 10000;

// Along an edge between two of `faces` no part of a face that lies over both is nearer to one than its height.
double height(const Corners& face) {
  const auto& [a, b, c] = face;
  const double longest = std::max({length(b - a), length(c - b), length(a - c)});
  return longest > 0 ? length(cross(b - a, c - a)) / longest : 0;
}

// The distance to one of `faces` is greatest at a corner; a face whose corners do not tell enough is halved.
double reach_of_face(const Surface& surface, const Corners& face, double enough, double precision) {
  Index nearest = 0;
  int halves = 0;
  double bound = 0, least = 0;  // of the greatest distance
  std::vector<Corners> left{face};
  while (!left.empty()) {
    const Corners now = left.back();
    const auto& [a, b, c] = now;
    left.pop_back();
    const Vec3 middle = (1.0 / 3) * (a + b + c);
    const double distance = surface.distance(middle, nearest);
    least = std::max(least, distance);
    const double most = std::max({surface.to_face(a, nearest), surface.to_face(b, nearest), surface.to_face(c, nearest)});
    if (most <= std::max(enough, least + precision) || ++halves > kMostHalves) {
      bound = std::max(bound, most);
      continue;
    }
    const std::array<double, 3> sides{length(b - a), length(c - b), length(a - c)};
    const std::size_t i = std::max_element(sides.begin(), sides.end()) - sides.begin();
    const Vec3 p = now[i], q = now[(i + 1) % 3], r = now[(i + 2) % 3], half = 0.5 * (p + q);
    left.push_back({p, half, r});
    left.push_back({half, q, r});
  }
  return bound;
}

}  // namespace

std::vector<double> reach_of(std::span<const Vec3> corners, std::span<const Vec3> points, std::span<const Face> faces,
                             double enough, double precision) {
  const Surface surface(points, faces);
  std::vector<double> reach;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const Corners face{corners[i], corners[i + 1], corners[i + 2]};
    reach.push_back(reach_of_face(surface, face, std::max(enough, height(face)), precision));
  }
  return reach;
}

double farthest(std::span<const Vec3> queries, std::span<const Vec3> points, std::span<const Face> faces,
                double limit) {
  const Surface surface(points, faces);
  double greatest = 0;
  Index nearest = 0;  // neighbours in the input are near each other: a good first guess
  for (const Vec3 p : queries) {
    greatest = std::max(greatest, surface.distance(p, nearest));
    if (greatest > limit) break;
  }
  return greatest;
}

}  // namespace bldsimp
