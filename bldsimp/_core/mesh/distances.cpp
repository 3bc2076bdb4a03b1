#include "mesh/distances.hpp"

#include <atomic>
#include <limits>
#include <tuple>

#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

// Neighbors among the queries are near each other, so the last one's face is a good first guess. It is
// forgotten after this many, wherever the threads part them: else the last bits could depend on that.
constexpr std::size_t kBlock = 512;
constexpr std::size_t kLeastBlocks = 4;

constexpr double kFar = std::numeric_limits<double>::infinity();

}  // namespace

FaceTree::FaceTree(Points points, Faces faces)
    : tree_(points, faces, list_indices(faces.size())), place_(faces.size()) {
  triangles_.reserve(faces.size());
  for (const Index face : tree_.order()) {
    const auto& [a, b, c] = faces[face];
    place_[face] = static_cast<Index>(triangles_.size());
    triangles_.emplace_back(points[a], points[b], points[c]);
  }
}

FaceTree::FaceTree(Points points, Faces faces, double limit) : FaceTree(points, faces) {
  panels_ = Panels(points, faces, tree_, limit);
}

double FaceTree::to_face(Vec3 query, Index face) const {
  return std::sqrt(triangles_[place_[face]].squared_distance(query));
}

double FaceTree::distance(Vec3 query, Index& nearest) const {
  Index place = place_[nearest];
  const double found = this->nearest(query, place);
  nearest = tree_.order()[place];
  return found;
}

double FaceTree::nearest(Vec3 query, Index& place, double enough) const {
  const double stop = enough * enough;
  double best = triangles_[place].squared_distance(query);
  tree_.visit(
      query, [&](const Box& box) { return best > stop && box.squared_distance(query) < best; },
      [&](Index i) {
        if (const double d = triangles_[i].squared_distance(query); d < best) {
          best = d;
          place = i;
        }
      });
  return std::sqrt(best);
}

bool FaceTree::within(Vec3 query, double limit, Index& nearest) const {
  const double square = limit * limit;
  if (triangles_[place_[nearest]].within(query, limit)) return true;
  bool found = false;
  tree_.visit(
      query, [&](const Box& box) { return !found && box.squared_distance(query) <= square; },
      [&](Index i) {
        if (found || !triangles_[i].within(query, limit)) return;
        found = true;
        nearest = tree_.order()[i];
      });
  return found;
}

FaceTree::Coverage FaceTree::find_coverage(const Triangle& piece, double longest, double limit, Vec3 normal,
                                           Index& place) const {
  const bool any = normal == Vec3{0, 0, 0};
  const auto near = [&](Index i, Vec3 p) {
    return any ? triangles_[i].within(p, limit) : triangles_[i].lies_under(p, limit) && triangles_[i].is_across(normal);
  };
  const auto holds = [&](Index i) {
    return std::all_of(piece.begin(), piece.end(), [&](const Vec3& p) { return near(i, p); });
  };
  if (holds(place)) return Coverage::whole;
  const Vec3 middle = centroid(piece);
  Coverage found = Coverage::nowhere;
  // A face that holds the whole piece is not much shorter than it.
  const double shortest = longest - 2 * limit;
  tree_.visit(
      middle,
      [&](const BoxNode& box) {
        return found != Coverage::whole && (found == Coverage::nowhere || box.longest >= shortest) &&
               box.squared_distance(middle) <= limit * limit;
      },
      [&](Index i) {
        if (found == Coverage::whole || !near(i, middle)) return;
        found = Coverage::middle;
        if (!holds(i)) return;
        found = Coverage::whole;
        place = i;
      });
  return found;
}

bool FaceTree::panel_holds(Points corners, Vec3 middle, double size, double limit) const {
  return !panels_.empty() && panel_holds(0, corners, middle, size, limit);
}

// A panel is about as large as its node.
bool FaceTree::panel_holds(Index at, Points corners, Vec3 middle, double size, double limit) const {
  const BoxNode& node = tree_.nodes()[at];
  const Vec3 extent = node.high - node.low;
  if (std::max({extent.x, extent.y, extent.z}) < 0.5 * size || node.squared_distance(middle) > limit * limit)
    return false;
  if (const Panel* panel = panels_.at(at); panel && panel->holds(corners, limit)) return true;
  return node.second != 0 &&
         (panel_holds(at + 1, corners, middle, size, limit) || panel_holds(node.second, corners, middle, size, limit));
}

std::vector<double> FaceTree::distances(Points queries) const {
  std::vector<double> found(queries.size(), kFar);
  if (triangles_.empty()) return found;
  parallel_each((queries.size() + kBlock - 1) / kBlock,
                [&](Index block) {
                  Index nearest = 0;
                  const std::size_t last = std::min((block + 1) * kBlock, queries.size());
                  for (std::size_t i = block * kBlock; i < last; ++i) found[i] = distance(queries[i], nearest);
                },
                kLeastBlocks);
  return found;
}

double FaceTree::farthest(Points queries, double limit) const {
  if (triangles_.empty()) return queries.empty() ? 0.0 : kFar;
  std::vector<double> greatest((queries.size() + kBlock - 1) / kBlock, 0.0);
  std::atomic<bool> beyond = false;
  parallel_each(
      greatest.size(),
      [&](Index block) {
        Index nearest = 0;
        const std::size_t last = std::min((block + 1) * kBlock, queries.size());
        for (std::size_t i = block * kBlock; i < last && !beyond; ++i) {
          greatest[block] = std::max(greatest[block], distance(queries[i], nearest));
          if (greatest[block] > limit) beyond = true;
        }
      },
      kLeastBlocks);
  return greatest.empty() ? 0.0 : *std::max_element(greatest.begin(), greatest.end());
}

}  // namespace bldsimp
