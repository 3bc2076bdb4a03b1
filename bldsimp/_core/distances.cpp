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
constexpr int kMostHalves = 1000000;

std::vector<Index> all(std::size_t count) {
  std::vector<Index> members(count);
  std::iota(members.begin(), members.end(), 0);
  return members;
}

}  // namespace

FaceTree::FaceTree(std::span<const Vec3> points, std::span<const Face> faces)
    : tree_(points, faces, all(faces.size())), place_(faces.size()) {
  triangles_.reserve(faces.size());
  for (const Index face : tree_.order()) {
    const auto& [a, b, c] = faces[face];
    place_[face] = static_cast<Index>(triangles_.size());
    triangles_.emplace_back(points[a], points[b], points[c]);
  }
}

double FaceTree::to_face(Vec3 query, Index face) const {
  return std::sqrt(triangles_[place_[face]].squared_distance(query));
}

double FaceTree::distance(Vec3 query, Index& nearest) const {
  Index place = place_[nearest];
  double best = triangles_[place].squared_distance(query);
  tree_.visit(
      query, [&](const Box& box) { return box.squared_distance(query) < best; },
      [&](Index i) {
        if (const double d = triangles_[i].squared_distance(query); d < best) {
          best = d;
          place = i;
        }
      });
  nearest = tree_.order()[place];
  return std::sqrt(best);
}

bool FaceTree::within(Vec3 query, double limit, Index& nearest) const {
  const double square = limit * limit;
  if (triangles_[place_[nearest]].squared_distance(query) <= square) return true;
  bool found = false;
  tree_.visit(
      query, [&](const Box& box) { return !found && box.squared_distance(query) <= square; },
      [&](Index i) {
        if (found || triangles_[i].squared_distance(query) > square) return;
        found = true;
        nearest = tree_.order()[i];
      });
  return found;
}

// The distance to one face is greatest at a corner; a triangle whose corners do not tell enough is halved.
double FaceTree::reach(const std::array<Vec3, 3>& triangle, double enough, double precision) const {
  if (triangles_.empty()) return kFar;
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
    for (const auto& half : halved(now)) left.push_back(half);
  }
  return bound;
}

FaceTree::Held FaceTree::held(const std::array<Vec3, 3>& piece, double longest, double limit, Index& place) const {
  const double square = limit * limit;
  const auto [a, b, c] = piece;
  const auto holds = [&](Index i) {
    const FramedTriangle& own = triangles_[i];
    return own.squared_distance(a) <= square && own.squared_distance(b) <= square && own.squared_distance(c) <= square;
  };
  if (holds(place)) return Held::whole;
  const Vec3 middle = (1.0 / 3) * (a + b + c);
  Held found = Held::nowhere;
  // A face that holds the whole piece is not much shorter than it.
  const double shortest = longest - 2 * limit;
  tree_.visit(
      middle,
      [&](const FaceBox& box) {
        return found != Held::whole && (found == Held::nowhere || box.longest >= shortest) &&
               box.squared_distance(middle) <= square;
      },
      [&](Index i) {
        if (found == Held::whole || triangles_[i].squared_distance(middle) > square) return;
        found = Held::middle;
        if (!holds(i)) return;
        found = Held::whole;
        place = i;
      });
  return found;
}

bool FaceTree::holds(const std::array<Vec3, 3>& triangle, double limit) const {
  if (triangles_.empty()) return false;
  const double shortest = limit * finest;
  Index place = 0;
  std::vector<std::array<Vec3, 3>> left{triangle};
  while (!left.empty()) {
    const auto now = left.back();
    left.pop_back();
    const double longest = longest_side(now);
    const Held found = held(now, longest, limit, place);
    if (found == Held::whole) continue;
    if (found == Held::nowhere || longest < shortest) return false;
    for (const auto& half : halved(now)) left.push_back(half);
  }
  return true;
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
