// Tell which triangles lean beside the walls, floors and roofs of a surface.
#pragma once

#include <optional>

#include "collapse/held_facets.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/framed_triangle.hpp"

namespace bldsimp {

class Walls {
 public:
  // O(m log m).
  Walls(Points points, Faces faces, std::span<const FlatFace> flat, double tolerance);

  // How far the middle of a triangle is from the nearest of them: of one that is parallel to none of those within the
  // tolerance. Its corners count from `origin`.
  std::optional<double> measure_leaning(const Triangle& t, Vec3 origin) const;

 private:
  struct Wall {
    FramedTriangle triangle;
    FlatFace flat;
  };

  double tolerance_;
  BoxTree tree_;
  std::vector<Wall> walls_;  // in the order of the tree
};

}  // namespace bldsimp
