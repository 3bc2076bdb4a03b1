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

double FaceTree::nearest(Vec3 query, Index& place) const {
  double best = triangles_[place].squared_distance(query);
  tree_.visit(
      query, [&](const Box& box) { return box.squared_distance(query) < best; },
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

FaceTree::Coverage FaceTree::find_coverage(const Triangle& piece, double longest, double limit, Index& place) const {
  const auto holds = [&](Index i) {
    return std::all_of(piece.begin(), piece.end(), [&](const Vec3& p) { return triangles_[i].within(p, limit); });
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
        if (found == Coverage::whole || !triangles_[i].within(middle, limit)) return;
        found = Coverage::middle;
        if (!holds(i)) return;
        found = Coverage::whole;
        place = i;
      });
  return found;
}

// Halves a triangle until each piece is within the limit of one face, and goes down the tree with it: only what is
// near a piece is looked at for its halves.
class FaceTree::HoldCheck {
 public:
  HoldCheck(const FaceTree& tree, double limit) : tree_(tree), nodes_(tree.tree_.nodes()), limit_(limit) {}

  bool holds(const Triangle& triangle) {
    near_.push_back(0);
    return piece_holds(triangle, 0);
  }

 private:
  // What is near the piece is among the nodes from `begin` on.
  bool piece_holds(const Triangle& piece, std::size_t begin) {
    if (holds(piece, guess_)) return true;
    const double longest = longest_side(piece);
    Box box = box_of(piece);
    const Vec3 around{limit_, limit_, limit_};
    box.low = box.low - around;
    box.high = box.high + around;
    const std::size_t end = near_.size();
    for (std::size_t i = begin; i < end; ++i)
      if (open(near_[i], piece, box, longest)) return done(end, true);
    // A face that holds the whole piece is not much shorter than it.
    for (std::size_t i = end; i < near_.size(); ++i)
      if (one_holds(piece, near_[i], box, longest - 2 * limit_)) return done(end, true);
    if (near_.size() == end || longest < limit_ * finest) return done(end, false);
    const auto halves = halve(piece);
    return done(end, piece_holds(halves[0], end) && piece_holds(halves[1], end));
  }

  // Nodes no longer than the piece, and those without halves; or whether the panel of one on the way to them holds it.
  bool open(Index at, const Triangle& piece, const Box& box, double longest) {
    const BoxNode& node = nodes_[at];
    if (!node.meets(box)) return false;
    if (const Panel* panel = tree_.panels_.at(at); panel && panel->holds(piece, limit_)) return true;
    const Vec3 size = node.high - node.low;
    if (node.second == 0 || std::max({size.x, size.y, size.z}) <= longest) {
      near_.push_back(at);
      return false;
    }
    return open(at + 1, piece, box, longest) || open(node.second, piece, box, longest);
  }

  bool one_holds(const Triangle& piece, Index at, const Box& box, double shortest) {
    const BoxNode& node = nodes_[at];
    if (node.longest < shortest || !node.meets(box)) return false;
    if (node.second != 0)
      return one_holds(piece, at + 1, box, shortest) || one_holds(piece, node.second, box, shortest);
    for (Index i = node.begin; i < node.end; ++i) {
      if (!holds(piece, i)) continue;
      guess_ = i;
      return true;
    }
    return false;
  }

  bool holds(const Triangle& piece, Index i) const {
    const FramedTriangle& own = tree_.triangles_[i];
    return std::all_of(piece.begin(), piece.end(), [&](const Vec3& p) { return own.within(p, limit_); });
  }

  bool done(std::size_t end, bool found) {
    near_.resize(end);
    return found;
  }

  const FaceTree& tree_;
  const std::vector<BoxNode>& nodes_;
  double limit_;
  Index guess_ = 0;
  std::vector<Index> near_;  // a stack
};

bool FaceTree::holds(const Triangle& triangle, double limit) const {
  return !triangles_.empty() && HoldCheck(*this, limit).holds(triangle);
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
