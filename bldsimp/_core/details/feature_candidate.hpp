// Define what may go as a whole, and what takes its place.
#pragma once

#include "details/loop_closing.hpp"

namespace bldsimp {

// What a feature is, by how it goes.
enum class FeatureKind : std::uint8_t {
  detail,         // one loop is closed: a recess, a sill, a chimney
  passage,        // several loops are closed
  boundary_loop,  // open edges are closed
  step            // a facet slides into the plane beside it
};

struct FeatureCandidate {
  FeatureKind kind;
  std::uint64_t id;           // tells the same one in another round
  std::vector<Index> facets;  // sorted, and so are the faces
  std::vector<Index> faces;
  std::vector<Index> around;  // facets whose planes the caps continue, sorted
  std::vector<Index> points;  // of faces and loops, sorted
  Caps caps;

  Vec3 place_of(Index point, Points points_before) const {
    for (const auto& [moved, to] : caps.moved)
      if (moved == point) return to;
    return points_before[point];
  }
};

}  // namespace bldsimp
