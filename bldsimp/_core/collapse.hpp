// Fewer points by collapsing edges, as far as a certified bound allows.
#pragma once

#include <span>
#include <vector>

#include "vec3.hpp"

namespace bldsimp {

// What a collapse was refused for.
enum class Refusal { fixed, link, fold, needle, backward, forward, border, crossing, count };

struct Collapsed {
  std::vector<Face> triangles;
  std::vector<Index> source;  // the triangle that each of them was
  std::vector<Index> holder;  // of each face of `surface`: a triangle of the result that holds some of it
  double deviation = 0;       // bound of the distance between `surface` and them, both ways
  std::vector<Index> refusals = std::vector<Index>(static_cast<std::size_t>(Refusal::count));
  Index accepted = 0;
};

struct CollapseInput {
  std::span<const Vec3> points;
  std::span<const Face> surface;            // what the tolerance counts from
  std::span<const Face> triangles;          // what is left of it, within the tolerance of it
  std::span<const Index> label;             // of each triangle; edges between two labels stay edges between them
  std::span<const std::uint8_t> pinned;     // triangles that stay
  double tolerance;
};

// Moves points onto neighbours, the ones that change the surface least first: topology stays (components, border
// loops, genus), no face turns over, and nothing of either surface is farther from the other than the tolerance;
// the same holds for the borders. Points of the result are points of the triangles. About O(n log n).
Collapsed collapse(const CollapseInput& input);

}  // namespace bldsimp
