// Find parts of a surface that are flat enough for a rectangle to stand for them.
#pragma once

#include "mesh/box_tree.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

// A rectangle of which every point has some point of the surface straight above or below it, between two heights.
struct Panel {
  Vec3 middle, x, y, z;  // the axes have length 1; z is square to the rectangle
  double width, depth;   // half of it, along x and y
  double low = 0, high = 0;

  // Whether every point between some corners is within a limit of the surface; never wrongly true.
  bool holds(Points corners, double limit) const;
};

// Of some nodes of a tree over the faces, those with a few dozen and a few hundred faces, where the surface is flat
// but for `limit`; neighbors overlap. O(n log n), on all cores.
class Panels {
 public:
  Panels() = default;
  Panels(Points points, Faces faces, const BoxTree& tree, double limit);

  bool empty() const { return panels_.empty(); }

  // The panel of a node, or nothing.
  const Panel* at(Index node) const { return place_.empty() || place_[node] < 0 ? nullptr : &panels_[place_[node]]; }

 private:
  std::vector<Index> place_;  // of each node's panel, or -1
  std::vector<Panel> panels_;
};

}  // namespace bldsimp
