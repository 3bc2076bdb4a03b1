// The order in which points are inserted: along a Hilbert curve, so that each lies near the last.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "predicates.hpp"

namespace bldsimp {

// Reusable workspace of `order`.
class HilbertOrder {
 public:
  // Indices of the points along the curve; equal points follow each other, the lowest index first.
  // Depends on the coordinates alone: the same points in any order give the same sequence of
  // coordinates. Valid until the next call. O(n) but for clusters far smaller than the whole,
  // which are ordered among themselves.
  std::span<const Index> order(std::span<const Point2> points);

 private:
  struct Keyed {
    std::uint32_t key;
    Index index;
  };
  void sort(std::span<const Point2> points, std::size_t begin, std::size_t end);
  void sort_by_key(std::size_t begin, std::size_t end);

  std::vector<Index> order_;
  std::vector<Keyed> keyed_, spare_;
};

}  // namespace bldsimp
