#include "details/ear_filling.hpp"

#include <map>
#include <queue>
#include <tuple>

namespace bldsimp {
namespace {

// Cosine beyond which two faces at an edge lie folded on one another.
constexpr double kFolded = -0.9;

// A corner of what is left to fill, as the middle of a face that would cut it off.
struct Ear {
  double length;
  Index middle, stamp;
  bool operator<(const Ear& o) const {  // the shortest is on top of the queue
    return std::tie(o.length, o.middle) < std::tie(length, middle);
  }
};

class LoopFiller {
 public:
  LoopFiller(const FacetGraph& graph, const Loop& loop) : graph_(graph), left_(loop.size()) {
    for (const auto& [from, to, outside] : loop) {
      simple_ &= corners_.try_emplace(from).second;
      corners_[from].next = to;
      normals_[key(from, to)] = normal(graph.faces()[outside]);
    }
    for (const LoopEdge& e : loop) corners_[e.to].before = e.from;
  }

  std::optional<std::vector<Face>> run() {
    if (!simple_ || left_ < 3) return {};
    for (const auto& [p, corner] : corners_) push(p);
    while (!ears_.empty()) {
      const Ear ear = ears_.top();
      ears_.pop();
      if (corners_[ear.middle].stamp != ear.stamp || !fits(ear.middle)) continue;
      const auto [a, b, stamp] = corners_[ear.middle];
      faces_.push_back({a, ear.middle, b});
      if (left_-- == 3) return std::move(faces_);
      ++corners_[ear.middle].stamp;
      corners_[a].next = b;
      corners_[b].before = a;
      normals_[key(a, b)] = normal(faces_.back());
      push(a);
      push(b);
    }
    return {};
  }

 private:
  struct Corner {
    Index before = -1, next = -1, stamp = 0;
  };

  static Edge key(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }
  Vec3 normal(const Face& f) const { return area_vector(corners_of(f, graph_.points())); }

  bool folds(const Face& face, Index a, Index b) const {
    const Vec3 n = normal(face), m = normals_.at(key(a, b));
    return dot(n, m) < kFolded * length(n) * length(m);
  }

  bool is_edge(Index a, Index b) const {
    const Indices star = graph_.faces_at(a);
    return normals_.contains(key(a, b)) ||
           std::any_of(star.begin(), star.end(), [&](Index f) { return has_corner(graph_.faces()[f], b); });
  }

  bool fits(Index middle) {
    const auto [a, b, stamp] = corners_[middle];
    const Face face{a, middle, b};
    if (folds(face, a, middle) || folds(face, middle, b)) return false;
    return left_ == 3 ? !folds(face, b, a) : !is_edge(a, b);
  }

  void push(Index middle) {
    Corner& corner = corners_[middle];
    const Vec3 way = graph_.points()[corner.next] - graph_.points()[corner.before];
    ears_.push({dot(way, way), middle, ++corner.stamp});
  }

  const FacetGraph& graph_;
  std::size_t left_;
  bool simple_ = true;
  std::map<Index, Corner> corners_;
  std::map<Edge, Vec3> normals_;  // of the face at each edge
  std::priority_queue<Ear> ears_;
  std::vector<Face> faces_;
};

}  // namespace

std::optional<std::vector<Face>> fill_loop(const FacetGraph& graph, const Loop& loop) {
  return LoopFiller(graph, loop).run();
}

}  // namespace bldsimp
