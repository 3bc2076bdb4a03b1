// Find triangles that pass through one another.
#pragma once

#include <optional>

#include "mesh/box_tree.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

// A triangle in space. Corners of two triangles that have one index must have one place.
struct IndexedTriangle {
  Face face;
  Triangle at;
};

// All pairs of faces that cross of which one is wanted, the lower index first, in rising order. Exact. O((n + k) log n)
// where boxes of faces tell most of them apart, on all cores; the same with any number of them.
//
// Two triangles cross where some point is inside of both; sides and corners are not inside. So a wall may stand on
// a slab, and a corner lie on a wall; but faces of one plane may not overlap, nor faces at one edge lie folded on one
// another. A triangle without area has no inside, and two with the same three corners are one.
std::vector<IndexPair> find_crossings(Points points, Faces faces, Flags wanted);

// A mesh that changes, and what its next step would make cross.
class CrossingTracker {
 public:
  struct Change {
    Index slot;
    IndexedTriangle triangle;
  };

  // Slots are the faces, in their order; those `beside` them stay as they are. The points must outlive this; one may
  // move once a change is committed that has all faces at it.
  CrossingTracker(Points points, Faces faces, Faces beside);

  // Whether the triangles of `fresh`, whose slots are among the `old` ones that they take the place of, would cross
  // one a triangle that stays, where nothing crossed before: where two sheets do cross, they may cross
  // along other triangles, but these must share a corner with those that crossed, and be no more pairs than those of
  // the old slots. Nothing may cross what is beside.
  // `around` are slots that share a corner with old ones. About O(log n); may run in several threads.
  bool makes_crossing(Indices old, Indices around, std::span<const Change> fresh) const;

  // Does so. About O(log n).
  void commit(Indices old, std::span<const Change> fresh);

 private:
  class EarlierCrossings;

  IndexedTriangle at(Index slot) const;
  template <class Leaf>
  bool visit(const Box& box, Indices old, Leaf leaf) const;
  void plant(std::vector<Index> slots);

  Points points_;
  std::vector<Face> slots_;
  std::vector<Index> place_;  // of each slot in the order of the tree
  std::vector<Box> boxes_;    // of each place; empty where nothing is left
  Index own_;
  std::size_t live_;
  std::optional<BoxTree> tree_;
};

}  // namespace bldsimp
