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
  void add(const Box& other) { add(other.low), add(other.high); }
  bool meets(const Box& o) const {
    return low.x <= o.high.x && o.low.x <= high.x && low.y <= o.high.y && o.low.y <= high.y && low.z <= o.high.z &&
           o.low.z <= high.z;
  }
  double squared_distance(Vec3 p) const {
    const Vec3 out{std::max({low.x - p.x, 0.0, p.x - high.x}), std::max({low.y - p.y, 0.0, p.y - high.y}),
                   std::max({low.z - p.z, 0.0, p.z - high.z})};
    return dot(out, out);
  }
};

// A node is a run of faces, halved at its middle. Built in O(n log n); points and faces are not needed after that.
class BoxTree {
 public:
  BoxTree(std::span<const Vec3> points, std::span<const Face> faces, std::vector<Index> members)
      : order_(std::move(members)) {
    if (!order_.empty()) build(points, faces, 0, order_.size());
  }

  // Calls leaf(face) for the faces of all leaves that enter(box) lets in, those near p first: `enter` may grow
  // stricter on the way.
  template <class Enter, class Leaf>
  void visit(Vec3 p, Enter enter, Leaf leaf) const {
    if (!order_.empty()) visit(p, 0, 0, order_.size(), enter, leaf);
  }

  // Calls leaf(place in the order) for the faces of all leaves whose box meets this one, until that is false; whether
  // it never was.
  template <class Leaf>
  bool visit(const Box& box, Leaf leaf) const {
    return order_.empty() || visit(box, 0, 0, order_.size(), leaf);
  }

  // The members, in the order of the leaves.
  std::span<const Index> order() const { return order_; }

  // Makes room for the member at this place of the order to grow. O(log m).
  void grow(std::size_t place, const Box& box) {
    std::size_t node = 0, begin = 0, end = order_.size();
    for (;;) {
      boxes_[node].add(box);
      if (end - begin <= few) return;
      const std::size_t half = begin + (end - begin) / 2;
      if (place < half)
        ++node, end = half;
      else
        node = second_[node], begin = half;
    }
  }

 private:
  static constexpr std::size_t few = 4;

  std::size_t build(std::span<const Vec3> points, std::span<const Face> faces, std::size_t begin, std::size_t end) {
    const auto middle = [&](Index face) {
      const auto [a, b, c] = faces[face];
      return points[a] + points[b] + points[c];
    };
    const std::size_t node = boxes_.size();
    Box box, middles;
    for (std::size_t i = begin; i < end; ++i) {
      for (const Index corner : faces[order_[i]]) box.add(points[corner]);
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
      for (std::size_t i = begin; i < end; ++i) leaf(order_[i]);
      return;
    }
    const std::size_t half = begin + (end - begin) / 2, first = node + 1, second = second_[node];
    const bool in_order = boxes_[first].squared_distance(p) <= boxes_[second].squared_distance(p);
    if (!in_order) visit(p, second, half, end, enter, leaf);
    visit(p, first, begin, half, enter, leaf);
    if (in_order) visit(p, second, half, end, enter, leaf);
  }

  template <class Leaf>
  bool visit(const Box& box, std::size_t node, std::size_t begin, std::size_t end, Leaf& leaf) const {
    if (!boxes_[node].meets(box)) return true;
    if (end - begin <= few) {
      for (std::size_t i = begin; i < end; ++i)
        if (!leaf(i)) return false;
      return true;
    }
    const std::size_t half = begin + (end - begin) / 2;
    return visit(box, node + 1, begin, half, leaf) && visit(box, second_[node], half, end, leaf);
  }

  std::vector<Index> order_;
  std::vector<Box> boxes_;
  std::vector<std::size_t> second_;  // the second child; the first follows its parent
};

}  // namespace bldsimp
