#include "collapse/redundant_bodies.hpp"

#include <cstdlib>
#include <memory>
#include <tuple>

#include "collapse/holder_normals.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/distances.hpp"
#include "mesh/edges.hpp"
#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

// What a body has of an edge of more than two faces: how many, and how many more run one way than the other.
struct EdgeShare {
  Index edge, uses, balance;
};

struct Body {
  std::vector<Index> faces;    // least first
  std::vector<Index> relying;  // faces of bodies that went, some of which need this one
  std::vector<EdgeShare> uses;
  Box box;
  std::unique_ptr<FaceTree> tree;
  bool pinned = false, may_go = false, gone = false;
};

// The rest of such an edge, and the bodies there.
struct CrowdedEdge {
  Index uses = 0, balance = 0;
  std::vector<Index> bodies;
};

class RedundantBodyFinder {
 public:
  RedundantBodyFinder(Points points, Faces faces, Indices body, Flags pinned, double limit);

  std::vector<std::uint8_t> run() {
    std::vector<std::uint8_t> spare(faces_.size(), 0);
    if (bodies_.size() < 2) return spare;
    build_trees();
    count_edges();
    for (std::vector<Index> bodies = find_candidates(); !bodies.empty();) bodies = remove(std::move(bodies));
    for (const Body& b : bodies_)
      if (b.gone)
        for (const Index f : b.faces) spare[f] = 1;
    return spare;
  }

 private:
  Triangle corners(Index f) const { return corners_of(faces_[f], points_); }

  void count_edges() {
    const auto count = static_cast<Index>(points_.size());
    EdgeBuckets(faces_, count).visit(0, count, [&](Indices edge) {
      if (edge.size() < 3) return;
      const auto index = static_cast<Index>(crowded_.size());
      CrowdedEdge& all = crowded_.emplace_back();
      for (const Index h : edge) {
        const Index own = body_of_[h / 3], way = origin(faces_, h) < target(faces_, h) ? 1 : -1;
        auto& uses = bodies_[own].uses;
        if (uses.empty() || uses.back().edge != index) {
          uses.push_back({index, 0, 0});
          all.bodies.push_back(own);
        }
        ++uses.back().uses, ++all.uses;
        uses.back().balance += way, all.balance += way;
      }
    });
  }

  void build_trees() {
    parallel_each(
        bodies_.size(),
        [&](Index b) {
          std::vector<Face> own;
          for (const Index f : bodies_[b].faces) own.push_back(faces_[f]);
          bodies_[b].tree = std::make_unique<FaceTree>(points_, own);
          const std::vector<Vec3> normals = find_holder_normals(points_, own, limit_);
          for (std::size_t i = 0; i < own.size(); ++i) normal_[bodies_[b].faces[i]] = normals[i];
        },
        1);
    // A face that is its longest side has the box that its ends span.
    std::vector<Vec3> ends;
    std::vector<Face> diagonals;
    std::vector<Index> all;
    for (const Body& b : bodies_) {
      const auto at = static_cast<Index>(ends.size());
      ends.insert(ends.end(), {b.box.low, b.box.high});
      diagonals.push_back({at, at + 1, at + 1});
      all.push_back(static_cast<Index>(all.size()));
    }
    boxes_ = std::make_unique<BoxTree>(ends, diagonals, all);
  }

  // Bodies that all the others together would hold.
  std::vector<Index> find_candidates() {
    parallel_each(
        bodies_.size(),
        [&](Index b) {
          std::vector<Index> holders;
          const auto other = [&](Index body) { return body != b; };
          Body& body = bodies_[b];
          body.may_go = !body.pinned && std::all_of(body.faces.begin(), body.faces.end(),
                                                    [&](Index f) { return holds(f, other, holders); });
        },
        64);
    std::vector<Index> found;
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (bodies_[b].may_go) found.push_back(static_cast<Index>(b));
    return found;
  }

  // The smallest first; ties go by the points of a body's least face.
  void sort_by_size(std::vector<Index>& bodies) const {
    const auto key = [&](Index b) {
      return std::tuple(length(bodies_[b].box.high - bodies_[b].box.low), faces_[bodies_[b].faces[0]]);
    };
    std::sort(bodies.begin(), bodies.end(), [&](Index b, Index c) { return key(b) < key(c); });
  }

  // Whether every point of a face is within the limit of bodies that may hold it. Each piece is held by one of their
  // faces, which is roughly parallel where the face needs that.
  template <class MayHold>
  bool holds(Index face, MayHold may_hold, std::vector<Index>& holders) const {
    std::vector<Triangle> left{corners(face)};
    holders.clear();
    Index holder = -1, place = 0;
    while (!left.empty()) {
      const auto now = left.back();
      left.pop_back();
      const Vec3 middle = centroid(now);
      const double longest = longest_side(now);
      auto found = FaceTree::Coverage::nowhere;
      const auto ask = [&](Index body, Index at) {
        const auto coverage = bodies_[body].tree->find_coverage(now, longest, limit_, normal_[face], at);
        found = std::max(found, coverage);
        if (coverage == FaceTree::Coverage::whole) holder = body, place = at;
      };
      if (holder >= 0) ask(holder, place);
      boxes_->visit(
          middle,
          [&](const Box& box) {
            return found != FaceTree::Coverage::whole && box.squared_distance(middle) <= limit_ * limit_;
          },
          [&](Index i) {
            const Index body = boxes_->order()[i];
            if (found != FaceTree::Coverage::whole && may_hold(body)) ask(body, 0);
          });
      if (found == FaceTree::Coverage::whole) {
        holders.push_back(holder);
        continue;
      }
      if (found == FaceTree::Coverage::nowhere || longest < limit_ * FaceTree::finest) return false;
      for (const auto& half : halve(now)) left.push_back(half);
    }
    sort_unique(holders);
    return true;
  }

  // Whether every edge of the rest keeps its balance and does not open.
  bool leaves_closed(const Body& body) const {
    return std::all_of(body.uses.begin(), body.uses.end(), [&](const EdgeShare& own) {
      const CrowdedEdge& all = crowded_[own.edge];
      const Index uses = all.uses - own.uses, balance = all.balance - own.balance;
      if (uses == 0) return true;
      return uses > 1 && (uses % 2 == 0 || all.uses % 2 == 1) && std::abs(balance) <= std::abs(all.balance);
    });
  }

  // Whether the rest holds a body, and what went before and relies on it; remembers how.
  bool rest_holds(Index b) {
    const Body& body = bodies_[b];
    std::vector<Index> wanted = body.faces, holders;
    append(wanted, body.relying);
    sort_unique(wanted);
    std::vector<std::pair<Index, Index>> holding;
    for (const Index f : wanted) {
      if (!holds(f, [&](Index other) { return other != b && !bodies_[other].gone; }, holders)) return false;
      for (const Index holder : holders) holding.push_back({holder, f});
    }
    for (const auto& [holder, f] : holding) bodies_[holder].relying.push_back(f);
    return true;
  }

  // Takes bodies away, the smallest first, and returns those at whose edges something has gone.
  std::vector<Index> remove(std::vector<Index> bodies) {
    sort_by_size(bodies);
    std::vector<Index> beside;
    for (const Index b : bodies) {
      Body& body = bodies_[b];
      if (!body.may_go || !leaves_closed(body)) continue;
      // What the rest does not hold, less of it never will.
      body.may_go = false;
      if (!rest_holds(b)) continue;
      body.gone = true;
      for (const EdgeShare& own : body.uses) {
        CrowdedEdge& all = crowded_[own.edge];
        all.uses -= own.uses, all.balance -= own.balance;
        append(beside, all.bodies);
      }
    }
    sort_unique(beside);
    return beside;
  }

  std::vector<Vec3> points_;  // about a local origin
  Faces faces_;
  double limit_;
  std::vector<Index> body_of_;
  std::vector<Vec3> normal_;  // of each face: its holders are roughly parallel to it; zero for any holder
  std::vector<Body> bodies_;
  std::vector<CrowdedEdge> crowded_;
  std::unique_ptr<BoxTree> boxes_;
};

RedundantBodyFinder::RedundantBodyFinder(Points points, Faces faces, Indices body, Flags pinned, double limit)
    : points_(about_middle(points)), faces_(faces), limit_(limit), body_of_(faces.size()), normal_(faces.size()) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto own = static_cast<Index>(f);
    if (body[f] == own) {
      body_of_[f] = static_cast<Index>(bodies_.size());
      bodies_.emplace_back();
    } else {
      body_of_[f] = body_of_[body[f]];
    }
    Body& b = bodies_[body_of_[f]];
    b.faces.push_back(own);
    b.pinned |= pinned[f] != 0;
    for (const Index p : faces[f]) b.box.add(points_[p]);
  }
}

}  // namespace

std::vector<std::uint8_t> find_redundant_bodies(Points points, Faces faces, Indices body, Flags pinned, double limit) {
  return RedundantBodyFinder(points, faces, body, pinned, limit).run();
}

}  // namespace bldsimp
