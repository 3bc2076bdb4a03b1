#include "distances.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>
#include <tuple>

#include "parallel.hpp"

namespace bldsimp {
namespace {

constexpr std::size_t kLeaf = 4;

// Neighbours among the queries are near each other, so the last one's face is a good first guess. It is
// forgotten after this many, wherever the threads part them: else the last bits could depend on that.
constexpr std::size_t kBlock = 512;
constexpr std::size_t kLeastBlocks = 4;

constexpr double kFar = std::numeric_limits<double>::infinity();

double square(double value) { return value * value; }

// Squared distance of (x, y) to the segment from the origin to (u, v), of which one is not 0.
double squared_segment_distance(double x, double y, double u, double v) {
  const double t = std::clamp((x * u + y * v) / (u * u + v * v), 0.0, 1.0);
  return square(x - t * u) + square(y - t * v);
}

}  // namespace

double FaceTree::Box::squared_distance(Vec3 p) const {
  const Vec3 out{std::max({low.x - p.x, 0.0, p.x - high.x}), std::max({low.y - p.y, 0.0, p.y - high.y}),
                 std::max({low.z - p.z, 0.0, p.z - high.z})};
  return dot(out, out);
}

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

FaceTree::FaceTree(std::span<const Vec3> points, std::span<const Face> faces) {
  if (faces.empty()) return;
  std::vector<std::size_t> order(faces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<Vec3> middles;
  middles.reserve(faces.size());
  for (const auto& [a, b, c] : faces) middles.push_back(points[a] + points[b] + points[c]);
  build(points, faces, middles, order);
  triangles_.reserve(faces.size());
  for (const std::size_t face : order) {
    const auto [a, b, c] = faces[face];
    triangles_.push_back(framed(points[a], points[b], points[c]));
  }
}

std::size_t FaceTree::build(std::span<const Vec3> points, std::span<const Face> faces,
                            std::span<const Vec3> middles, std::span<std::size_t> order) {
  const std::size_t node = boxes_.size();
  Box box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}}, spread = box;
  const auto add = [](Box& to, Vec3 p) {
    to.low = {std::min(to.low.x, p.x), std::min(to.low.y, p.y), std::min(to.low.z, p.z)};
    to.high = {std::max(to.high.x, p.x), std::max(to.high.y, p.y), std::max(to.high.z, p.z)};
  };
  for (const std::size_t face : order) {
    for (const Index corner : faces[face]) add(box, points[corner]);
    add(spread, middles[face]);
  }
  boxes_.push_back(box);
  second_.push_back(0);
  if (order.size() <= kLeaf) return node;
  const Vec3 size = spread.high - spread.low;
  double Vec3::*axis = &Vec3::x;
  if (size.y > size.*axis) axis = &Vec3::y;
  if (size.z > size.*axis) axis = &Vec3::z;
  const std::size_t half = order.size() / 2;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                   [&](std::size_t f, std::size_t g) { return middles[f].*axis < middles[g].*axis; });
  build(points, faces, middles, order.first(half));
  second_[node] = build(points, faces, middles, order.subspan(half));
  return node;
}

double FaceTree::distance(Vec3 query, std::size_t& nearest) const {
  Search search{query, triangles_[nearest].squared_distance(query), nearest};
  descend(search, 0, 0, triangles_.size());
  nearest = search.nearest;
  return std::sqrt(search.best);
}

void FaceTree::descend(Search& search, std::size_t node, std::size_t begin, std::size_t end) const {
  if (end - begin <= kLeaf) {
    for (std::size_t i = begin; i < end; ++i) {
      const double d = triangles_[i].squared_distance(search.query);
      if (d < search.best) {
        search.best = d;
        search.nearest = i;
      }
    }
    return;
  }
  const std::size_t half = begin + (end - begin) / 2, first = node + 1, second = second_[node];
  const double to_first = boxes_[first].squared_distance(search.query);
  const double to_second = boxes_[second].squared_distance(search.query);
  const auto into_first = [&] {
    if (to_first < search.best) descend(search, first, begin, half);
  };
  if (to_first <= to_second) into_first();
  if (to_second < search.best) descend(search, second, half, end);
  if (to_first > to_second) into_first();
}

std::vector<double> FaceTree::distances(std::span<const Vec3> queries) const {
  std::vector<double> found(queries.size(), kFar);
  if (triangles_.empty()) return found;
  parallel_for(
      (queries.size() + kBlock - 1) / kBlock,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t block = begin; block < end; ++block) {
          std::size_t nearest = 0;
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
          std::size_t nearest = 0;
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
