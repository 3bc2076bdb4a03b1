// Order points for insertion: in rounds, each along a Hilbert curve. Each point then lies near the last one, and no
// arrangement of the points is the worst case.
#pragma once

#include "mesh/predicates.hpp"

namespace bldsimp {

// Reusable workspace of `order`.
class HilbertOrder {
 public:
  // Indices of the points as to be inserted; equal points follow each other, the lowest index first.
  // Depends on the coordinates alone: the same points in any order give the same sequence of
  // coordinates. Valid until the next call. O(n), clusters far smaller than the whole once more.
  Indices order(std::span<const Point2> points);
  // The same in one round.
  Indices along_curve(std::span<const Point2> points);

 private:
  struct Keyed {
    std::uint32_t key;
    Index index;
  };
  void sort(std::span<const Point2> points, std::size_t begin, std::size_t end);
  void into_rounds(std::span<const Point2> points);
  void sort_by_key(std::size_t begin, std::size_t end);

  std::vector<Index> order_, spare_order_;
  std::vector<std::uint8_t> round_;
  std::vector<Keyed> keyed_, spare_;
};

}  // namespace bldsimp
