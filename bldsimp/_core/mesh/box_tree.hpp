// Build a tree of boxes over some faces of a mesh.
#pragma once

#include <limits>

#include "mesh/vec3.hpp"

namespace bldsimp {

struct Box {
  Vec3 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  Vec3 high{-low.x, -low.y, -low.z};

  void add(Vec3 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void add(const Box& o) { add(o.low), add(o.high); }
  double squared_distance(Vec3 p) const {
    const Vec3 out{std::max({low.x - p.x, 0.0, p.x - high.x}), std::max({low.y - p.y, 0.0, p.y - high.y}),
                   std::max({low.z - p.z, 0.0, p.z - high.z})};
    return dot(out, out);
  }
  bool meets(const Box& o) const {
    return low.x <= o.high.x && o.low.x <= high.x && low.y <= o.high.y && o.low.y <= high.y && low.z <= o.high.z &&
           o.low.z <= high.z;
  }
};

inline Box box_of(const Triangle& t) {
  Box box;
  for (const Vec3& p : t) box.add(p);
  return box;
}
inline double Vec3::* longest_axis(const Box& box) {
  const Vec3 size = box.high - box.low;
  double Vec3::* axis = &Vec3::x;
  if (size.y > size.*axis) axis = &Vec3::y;
  if (size.z > size.*axis) axis = &Vec3::z;
  return axis;
}

// Faces that are near each other: a run of the tree's order, in two halves where there are more than a few.
struct BoxNode : Box {
  double longest = 0;                    // side of any of the faces
  Index begin = 0, end = 0, second = 0;  // the second half; the first follows its node; 0 where there is none
};

// Built in O(n log n); points and faces are not needed after that.
class BoxTree {
 public:
  static constexpr Index few = 4;

  BoxTree(Points points, Faces faces, std::vector<Index> members) : order_(std::move(members)) {
    if (order_.empty()) return;
    std::vector<Vec3> middles(faces.size());
    for (const Index face : order_) {
      const auto [a, b, c] = faces[face];
      middles[face] = points[a] + points[b] + points[c];
    }
    build(points, faces, middles, 0, static_cast<Index>(order_.size()));
  }

  // The faces, in an order in which near ones mostly are beside each other.
  const std::vector<Index>& order() const { return order_; }

  // The first is the root.
  const std::vector<BoxNode>& nodes() const { return nodes_; }

  // Calls leaf(i), where order()[i] is the face, for all leaves that enter(box) lets in, those near p first: `enter`
  // may grow stricter on the way.
  template <class Enter, class Leaf>
  void visit(Vec3 p, Enter enter, Leaf leaf) const {
    if (!order_.empty()) visit(p, 0, enter, leaf);
  }

  // Calls leaf(i) as above for all leaves whose box meets this one, until that is false; whether it never was.
  template <class Leaf>
  bool visit(const Box& box, Leaf leaf) const {
    return order_.empty() || visit(box, 0, leaf);
  }

  // Makes room for order()[i] to grow. O(log m).
  void grow(Index i, const Box& box) {
    for (std::size_t at = 0;;) {
      BoxNode& node = nodes_[at];
      node.add(box);
      if (node.second == 0) return;
      at = i < nodes_[node.second].begin ? at + 1 : static_cast<std::size_t>(node.second);
    }
  }

 private:
  // Three times the middles of faces tell where they are.
  void build(Points points, Faces faces, Points middle, Index begin, Index end) {
    const std::size_t node = nodes_.size();
    BoxNode box;
    Box middles;
    for (Index i = begin; i < end; ++i) {
      const auto [a, b, c] = faces[order_[i]];
      for (const Index corner : {a, b, c}) box.add(points[corner]);
      for (const auto& [p, q] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
        box.longest = std::max(box.longest, length(points[q] - points[p]));
      middles.add(middle[order_[i]]);
    }
    box.begin = begin;
    box.end = end;
    nodes_.push_back(box);
    if (end - begin <= few) return;
    double Vec3::* const axis = longest_axis(middles);
    const Index half = begin + (end - begin) / 2;
    const auto at = [&](Index i) { return order_.begin() + i; };
    std::nth_element(at(begin), at(half), at(end), [&](Index f, Index g) { return middle[f].*axis < middle[g].*axis; });
    build(points, faces, middle, begin, half);
    nodes_[node].second = static_cast<Index>(nodes_.size());
    build(points, faces, middle, half, end);
  }

  template <class Enter, class Leaf>
  void visit(Vec3 p, std::size_t at, Enter& enter, Leaf& leaf) const {
    const BoxNode& node = nodes_[at];
    if (!enter(node)) return;
    if (node.second == 0) {
      for (Index i = node.begin; i < node.end; ++i) leaf(i);
      return;
    }
    const std::size_t first = at + 1, second = static_cast<std::size_t>(node.second);
    const bool in_order = nodes_[first].squared_distance(p) <= nodes_[second].squared_distance(p);
    if (!in_order) visit(p, second, enter, leaf);
    visit(p, first, enter, leaf);
    if (in_order) visit(p, second, enter, leaf);
  }

  template <class Leaf>
  bool visit(const Box& box, std::size_t at, Leaf& leaf) const {
    const BoxNode& node = nodes_[at];
    if (!node.meets(box)) return true;
    if (node.second != 0) return visit(box, at + 1, leaf) && visit(box, static_cast<std::size_t>(node.second), leaf);
    for (Index i = node.begin; i < node.end; ++i)
      if (!leaf(i)) return false;
    return true;
  }

  std::vector<Index> order_;
  std::vector<BoxNode> nodes_;
};

}  // namespace bldsimp
