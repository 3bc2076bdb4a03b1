// Join faces across edges, or other items, into sets.
#pragma once

#include "mesh/parallel.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

// Disjoint sets of 0 .. count - 1. The root of a set is its least item, so that the result knows no order.
class IndexSets {
 public:
  explicit IndexSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

  Index find(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(Index i, Index j) {
    i = find(i);
    j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }
  // The root of each item; parents come before their children.
  Array<Index> roots() && {
    for (Index& parent : parent_) parent = parent_[parent];
    return std::move(parent_);
  }

 private:
  Array<Index> parent_;
};

// Calls visit(lower, higher) for the pairs of twins whose lower halfedge is in first .. last - 1. Lower ones
// are picked out in advance: as a branch between visits this would be guessed wrong every other time.
template <class Visit>
void for_twins(Indices twin, std::size_t first, std::size_t last, Visit visit) {
  std::array<Index, 512> lower;
  while (first < last) {
    const std::size_t end = std::min(last, first + lower.size());
    std::size_t count = 0;
    for (; first < end; ++first) {
      lower[count] = static_cast<Index>(first);
      count += twin[first] > static_cast<Index>(first);
    }
    for (std::size_t i = 0; i < count; ++i) visit(lower[i], twin[lower[i]]);
  }
}

// The least face of the set of each face, where faces are joined across the twins that `joins(h, twin)` asks
// for. Each thread joins its own range of faces; what crosses ranges comes last. O(halfedges), nearly.
template <class Joins>
Array<Index> join_across(Indices twin, Joins joins) {
  IndexSets sets(twin.size() / 3);
  std::vector<IndexPair> crossing;
  parallel_collect(
      twin.size() / 3,
      [&](std::size_t first, std::size_t last) {
        std::vector<IndexPair> own;
        for_twins(twin, 3 * first, 3 * last, [&](Index h, Index t) {
          if (!joins(h, t)) return;
          if (t / 3 < static_cast<Index>(last))
            sets.join(h / 3, t / 3);
          else
            own.push_back({h / 3, t / 3});
        });
        return own;
      },
      [&](const std::vector<IndexPair>& own) { append(crossing, own); });
  for (const auto& [f, g] : crossing) sets.join(f, g);
  return std::move(sets).roots();
}

}  // namespace bldsimp
