// A tree of boxes over some faces of a mesh.
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "vec3.hpp"

namespace bldsimp {

struct Box {
  Vec3 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  Vec3 high{-low.x, -low.y, -low.z};

  void add(Vec3 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  double squared_distance(Vec3 p) const {
    const Vec3 out{std::max({low.x - p.x, 0.0, p.x - high.x}), std::max({low.y - p.y, 0.0, p.y - high.y}),
                   std::max({low.z - p.z, 0.0, p.z - high.z})};
    return dot(out, out);
  }
};

// The box of some faces, and the longest side of any of them.
struct FaceBox : Box {
  double longest = 0;
};

// A node is a run of faces, halved at its middle. Built in O(n log n); points and faces are not needed after that.
class BoxTree {
 public:
  static constexpr std::size_t few = 4;  // as many faces a run has that is not halved again

  BoxTree(std::span<const Vec3> points, std::span<const Face> faces, std::vector<Index> members)
      : order_(std::move(members)) {
    if (!order_.empty()) build(points, faces, 0, order_.size());
  }

  // The faces, in an order in which near ones mostly are beside each other.
  const std::vector<Index>& order() const { return order_; }

  // Calls leaf(i), where order()[i] is the face, for all leaves that enter(box) lets in, those near p first: `enter`
  // may grow stricter on the way.
  template <class Enter, class Leaf>
  void visit(Vec3 p, Enter enter, Leaf leaf) const {
    if (!order_.empty()) visit(p, 0, 0, order_.size(), enter, leaf);
  }

 private:
  std::size_t build(std::span<const Vec3> points, std::span<const Face> faces, std::size_t begin, std::size_t end) {
    const auto middle = [&](Index face) {
      const auto [a, b, c] = faces[face];
      return points[a] + points[b] + points[c];
    };
    const std::size_t node = boxes_.size();
    FaceBox box;
    Box middles;
    for (std::size_t i = begin; i < end; ++i) {
      const auto [a, b, c] = faces[order_[i]];
      for (const Index corner : {a, b, c}) box.add(points[corner]);
      for (const auto& [p, q] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
        box.longest = std::max(box.longest, length(points[q] - points[p]));
      middles.add(middle(order_[i]));
    }
    boxes_.push_back(box);
    second_.push_back(0);
    if (end - begin <= few) return node;
    const Vec3 size = middles.high - middles.low;
    double Vec3::*axis = &Vec3::x;
    if (size.y > size.*axis) axis = &Vec3::y;
    if (size.z > size.*axis) axis = &Vec3::z;
    const std::size_t half = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(half), at(end),
                     [&](Index f, Index g) { return middle(f).*axis < middle(g).*axis; });
    build(points, faces, begin, half);
    second_[node] = build(points, faces, half, end);
    return node;
  }

  template <class Enter, class Leaf>
  void visit(Vec3 p, std::size_t node, std::size_t begin, std::size_t end, Enter& enter, Leaf& leaf) const {
    if (!enter(boxes_[node])) return;
    if (end - begin <= few) {
      for (std::size_t i = begin; i < end; ++i) leaf(static_cast<Index>(i));
      return;
    }
    const std::size_t half = begin + (end - begin) / 2, first = node + 1, second = second_[node];
    const bool in_order = boxes_[first].squared_distance(p) <= boxes_[second].squared_distance(p);
    if (!in_order) visit(p, second, half, end, enter, leaf);
    visit(p, first, begin, half, enter, leaf);
    if (in_order) visit(p, second, half, end, enter, leaf);
  }

  std::vector<Index> order_;
  std::vector<FaceBox> boxes_;
  std::vector<std::size_t> second_;  // the second child; the first follows its parent
};

}  // namespace bldsimp
