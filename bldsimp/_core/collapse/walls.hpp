// Find triangles that lean: wide ones that are parallel to no wall, floor or roof near them.
#pragma once

#include <optional>

#include "collapse/held_facets.hpp"
#include "mesh/distances.hpp"

namespace bldsimp {

class Walls {
 public:
  // O(m log m).
  Walls(Points points, Faces faces, std::span<const FlatFace> flat, double tolerance);

  // Distance of the middle of a triangle from the nearest wall. Nothing if no wall is within the tolerance, or one that
  // is lies parallel to the triangle. The corners count from `origin`.
  std::optional<double> measure_leaning(const Triangle& t, Vec3 origin) const;

 private:
  std::vector<FlatFace> flat_;
  double tolerance_;
  FaceTree tree_;  // of these
};

}  // namespace bldsimp
