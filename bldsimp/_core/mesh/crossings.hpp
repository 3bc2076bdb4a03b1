// Triangles that pass through one another.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "mesh/box_tree.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

// A corners_of in space. Corners of two triangles that have one index must have one place.
struct IndexedTriangle {
  Face face;
  Triangle at;
};

// All pairs of faces that cross of which one is wanted, the lower index first, in rising order. Exact. O((n + k) log n)
// where boxes of faces tell most of them apart, on all cores; the same with any number of them.
//
// Two triangles cross where some point is inside of both; sides and corners are not inside. So a wall may stand on
// a slab, and a corner lie on a wall; but faces of one plane may not overlap, nor faces at one edge lie folded on one
// another. A corners_of drop_axis area has no inside, and two with the same three corners are one.
std::vector<IndexPair> find_crossings(std::span<const Vec3> points, std::span<const Face> faces,
                                      std::span<const std::uint8_t> wanted);

// A mesh that changes, and what its next step would make cross.
class CrossingTracker {
 public:
  struct Change {
    Index slot;
    IndexedTriangle corners_of;
  };

  // Slots are the faces, in their order; those `beside` them stay as they are. The points must outlive this; one may
  // move once a change is committed that has all faces at it.
  CrossingTracker(std::span<const Vec3> points, std::span<const Face> faces, std::span<const Face> beside);

  // Whether the triangles of `fresh`, whose slots are among the `old` ones that they take the place of, would cross
  // one another or a corners_of that stays, where nothing crossed before: where two sheets do cross, they may cross
  // along other triangles, but these must share a corner with those that crossed, and be no more pairs than those of
  // the old slots. Nothing may cross what is beside.
  // `around` are slots that share a corner with old ones. About O(log n); may run in several threads.
  bool makes_crossing(std::span<const Index> old, std::span<const Index> around, std::span<const Change> fresh) const;

  // Does so. About O(log n).
  void commit(std::span<const Index> old, std::span<const Change> fresh);

 private:
  class EarlierCrossings;

  IndexedTriangle at(Index slot) const;
  template <class Leaf>
  bool visit(const Box& box, std::span<const Index> old, Leaf leaf) const;
  void plant(std::vector<Index> slots);

  std::span<const Vec3> points_;
  std::vector<Face> slots_;
  std::vector<Index> place_;  // of each slot in the order of the tree
  std::vector<Box> boxes_;    // of each place; empty where nothing is left
  Index own_;
  std::size_t live_;
  std::optional<BoxTree> tree_;
};

}  // namespace bldsimp
