#include "farthest.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

namespace bldsimp {
namespace {

constexpr std::size_t kLeaf = 4;

struct Box {
  Vec3 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  Vec3 high{-low.x, -low.y, -low.z};

  void add(Vec3 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  double distance(Vec3 p) const {
    const Vec3 out{std::max({low.x - p.x, 0.0, p.x - high.x}), std::max({low.y - p.y, 0.0, p.y - high.y}),
                   std::max({low.z - p.z, 0.0, p.z - high.z})};
    return length(out);
  }
};

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

// A tree of boxes over the faces: a node is a run of `order`, halved at its middle.
class Tree {
 public:
  Tree(std::span<const Vec3> points, std::span<const Face> faces) : points_(points), faces_(faces) {
    order_.resize(faces.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    build(0, faces.size());
  }

  double distance(Vec3 p, std::size_t& nearest) const {
    double best = to_face(p, nearest);
    search(p, 0, 0, faces_.size(), best, nearest);
    return best;
  }

  double to_face(Vec3 p, std::size_t face) const {
    const auto [a, b, c] = faces_[face];
    return face_distance(p, points_[a], points_[b], points_[c]);
  }

 private:
  Vec3 middle(std::size_t face) const {
    const auto [a, b, c] = faces_[face];
    return points_[a] + points_[b] + points_[c];
  }

  std::size_t build(std::size_t begin, std::size_t end) {
    const std::size_t node = boxes_.size();
    Box box, middles;
    for (std::size_t i = begin; i < end; ++i) {
      for (const Index corner : faces_[order_[i]]) box.add(points_[corner]);
      middles.add(middle(order_[i]));
    }
    boxes_.push_back(box);
    second_.push_back(0);
    if (end - begin <= kLeaf) return node;
    const Vec3 size = middles.high - middles.low;
    double Vec3::*axis = &Vec3::x;
    if (size.y > size.*axis) axis = &Vec3::y;
    if (size.z > size.*axis) axis = &Vec3::z;
    const std::size_t half = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(half), at(end),
                     [&](std::size_t f, std::size_t g) { return middle(f).*axis < middle(g).*axis; });
    build(begin, half);
    second_[node] = build(half, end);
    return node;
  }

  void search(Vec3 p, std::size_t node, std::size_t begin, std::size_t end, double& best,
              std::size_t& nearest) const {
    if (boxes_[node].distance(p) >= best) return;
    if (end - begin <= kLeaf) {
      for (std::size_t i = begin; i < end; ++i) {
        const double d = to_face(p, order_[i]);
        if (d < best) {
          best = d;
          nearest = order_[i];
        }
      }
      return;
    }
    const std::size_t half = begin + (end - begin) / 2, first = node + 1, second = second_[node];
    if (boxes_[first].distance(p) <= boxes_[second].distance(p)) {
      search(p, first, begin, half, best, nearest);
      search(p, second, half, end, best, nearest);
    } else {
      search(p, second, half, end, best, nearest);
      search(p, first, begin, half, best, nearest);
    }
  }

  std::span<const Vec3> points_;
  std::span<const Face> faces_;
  std::vector<std::size_t> order_;
  std::vector<Box> boxes_;
  std::vector<std::size_t> second_;  // the second child; the first follows its parent
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
double reach_of_face(const Tree& tree, const Corners& face, double enough, double precision) {
  std::size_t nearest = 0;
  int halves = 0;
  double bound = 0, least = 0;  // of the greatest distance
  std::vector<Corners> left{face};
  while (!left.empty()) {
    const Corners now = left.back();
    const auto& [a, b, c] = now;
    left.pop_back();
    const Vec3 middle = (1.0 / 3) * (a + b + c);
    const double distance = tree.distance(middle, nearest);
    least = std::max(least, distance);
    const double most = std::max({tree.to_face(a, nearest), tree.to_face(b, nearest), tree.to_face(c, nearest)});
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
  const Tree tree(points, faces);
  std::vector<double> reach;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const Corners face{corners[i], corners[i + 1], corners[i + 2]};
    reach.push_back(reach_of_face(tree, face, std::max(enough, height(face)), precision));
  }
  return reach;
}

double farthest(std::span<const Vec3> queries, std::span<const Vec3> points, std::span<const Face> faces,
                double limit) {
  const Tree tree(points, faces);
  double greatest = 0;
  std::size_t nearest = 0;  // neighbours in the input are near each other: a good first guess
  for (const Vec3 p : queries) {
    greatest = std::max(greatest, tree.distance(p, nearest));
    if (greatest > limit) break;
  }
  return greatest;
}

}  // namespace bldsimp
