#include "distances.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>
#include <tuple>

#include "parallel.hpp"

namespace bldsimp {
namespace {

// Neighbours among the queries are near each other, so the last one's face is a good first guess. It is
// forgotten after this many, wherever the threads part them: else the last bits could depend on that.
constexpr std::size_t kBlock = 512;
constexpr std::size_t kLeastBlocks = 4;

constexpr double kFar = std::numeric_limits<double>::infinity();

// Halves of one triangle: far more than any but a made-up case needs. What is left then counts as it is.
constexpr int kMostHalves = 10000;

double square(double value) { return value * value; }

// Squared distance of (x, y) to the segment from the origin to (u, v), of which one is not 0.
double squared_segment_distance(double x, double y, double u, double v) {
  const double t = std::clamp((x * u + y * v) / (u * u + v * v), 0.0, 1.0);
  return square(x - t * u) + square(y - t * v);
}

// Along an edge between two faces no part of a triangle that lies over both is nearer to one than its height.
double height(const std::array<Vec3, 3>& triangle) {
  const auto& [a, b, c] = triangle;
  const double longest = std::max({length(b - a), length(c - b), length(a - c)});
  return longest > 0 ? length(cross(b - a, c - a)) / longest : 0;
}

std::vector<Index> all(std::size_t count) {
  std::vector<Index> members(count);
  std::iota(members.begin(), members.end(), 0);
  return members;
}

}  // namespace

// Directions are unit vectors made square to each other, so that the triangle in its frame is the one
// stored but for a few roundings, however thin it is.
FaceTree::Triangle FaceTree::framed(Vec3 a, Vec3 b, Vec3 c) {
  const double ab = length(b - a), bc = length(c - b), ca = length(a - c);
  if (bc > ab && bc >= ca)
    std::tie(a, b, c) = std::tuple(b, c, a);
  else if (ca > ab)
    std::tie(a, b, c) = std::tuple(c, a, b);
  Triangle t{a, {0, 0, 0}, {0, 0, 0}, length(b - a), 0, 0};
  if (t.length == 0) return t;
  t.x = (1 / t.length) * (b - a);
  const Vec3 side = c - a;
  t.foot = dot(side, t.x);
  Vec3 up = side - t.foot * t.x;
  up = up - dot(up, t.x) * t.x;
  t.height = length(up);
  if (t.height > 0) t.y = (1 / t.height) * up;
  return t;
}

double FaceTree::Triangle::squared_distance(Vec3 p) const {
  const Vec3 way = p - origin;
  const double u = dot(way, x);
  const Vec3 rest = way - u * x;
  const double v = dot(rest, y);
  const Vec3 out = rest - v * y;
  const double across = dot(out, out);
  if (v <= 0) return across + square(v) + square(u - std::clamp(u, 0.0, length));
  const bool left = foot * v > height * u, right = (length - foot) * v > height * (length - u);
  double within = left || right ? kFar : 0.0;
  if (left) within = squared_segment_distance(u, v, foot, height);
  if (right) within = std::min(within, squared_segment_distance(u - length, v, foot - length, height));
  return across + within;
}

FaceTree::FaceTree(std::span<const Vec3> points, std::span<const Face> faces)
    : tree_(points, faces, all(faces.size())) {
  triangles_.reserve(faces.size());
  for (const auto& [a, b, c] : faces) triangles_.push_back(framed(points[a], points[b], points[c]));
}

double FaceTree::to_face(Vec3 query, Index face) const { return std::sqrt(triangles_[face].squared_distance(query)); }

double FaceTree::distance(Vec3 query, Index& nearest) const {
  double best = triangles_[nearest].squared_distance(query);
  tree_.visit(
      query, [&](const Box& box) { return box.squared_distance(query) < best; },
      [&](Index face) {
        if (const double d = triangles_[face].squared_distance(query); d < best) {
          best = d;
          nearest = face;
        }
      });
  return std::sqrt(best);
}

// The distance to one face is greatest at a corner; a triangle whose corners do not tell enough is halved.
double FaceTree::reach(const std::array<Vec3, 3>& triangle, double enough, double precision) const {
  if (triangles_.empty()) return kFar;
  enough = std::max(enough, height(triangle));
  Index nearest = 0;
  int halves = 0;
  double bound = 0, least = 0;  // of the greatest distance
  std::vector<std::array<Vec3, 3>> left{triangle};
  while (!left.empty()) {
    const auto now = left.back();
    const auto& [a, b, c] = now;
    left.pop_back();
    least = std::max(least, distance((1.0 / 3) * (a + b + c), nearest));
    const double most = std::max({to_face(a, nearest), to_face(b, nearest), to_face(c, nearest)});
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

std::vector<double> FaceTree::distances(std::span<const Vec3> queries) const {
  std::vector<double> found(queries.size(), kFar);
  if (triangles_.empty()) return found;
  parallel_for(
      (queries.size() + kBlock - 1) / kBlock,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t block = begin; block < end; ++block) {
          Index nearest = 0;
          const std::size_t last = std::min((block + 1) * kBlock, queries.size());
          for (std::size_t i = block * kBlock; i < last; ++i) found[i] = distance(queries[i], nearest);
        }
      },
      kLeastBlocks);
  return found;
}

double FaceTree::farthest(std::span<const Vec3> queries, double limit) const {
  if (triangles_.empty()) return queries.empty() ? 0.0 : kFar;
  std::vector<double> greatest((queries.size() + kBlock - 1) / kBlock, 0.0);
  std::atomic<bool> beyond = false;
  parallel_for(
      greatest.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t block = begin; block < end; ++block) {
          Index nearest = 0;
          const std::size_t last = std::min((block + 1) * kBlock, queries.size());
          for (std::size_t i = block * kBlock; i < last && !beyond; ++i) {
            greatest[block] = std::max(greatest[block], distance(queries[i], nearest));
            if (greatest[block] > limit) beyond = true;
          }
        }
      },
      kLeastBlocks);
  return greatest.empty() ? 0.0 : *std::max_element(greatest.begin(), greatest.end());
}

}  // namespace bldsimp
