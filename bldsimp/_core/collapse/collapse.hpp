// Collapse edges as far as a certified bound allows.
#pragma once

#include <atomic>

#include "mesh/vec3.hpp"

namespace bldsimp {

// Why a collapse was refused.
enum class Refusal { link, fold, needle, border, backward, forward, crossing, count };

// What has been done so far, for another thread to look at.
struct Progress {
  std::atomic<std::int64_t> removed = 0;  // points
};

struct CollapseInput {
  Points points;
  Faces surface;     // what the tolerance counts from, and after it faces that fill holes
  Indices label;     // of each face; edges between two labels stay edges between them
  Flags pinned;      // faces that stay
  Flags left_out;    // faces that are not to be in the result; others must hold them
  Index fill_count;  // the last so many faces close the surface, and are none of it
  double tolerance;
  int decimals;           // that a moved point is rounded to; below 0 none moves
  bool single;            // whether a moved point is rounded to single precision after that
  Progress* progress;     // or none
  Flags fixed = {};       // points that stay where they are; empty for none
  Points positions = {};  // of the points before the first collapse, where they have moved; empty where they have not

  // What the tolerance counts from.
  Faces counting() const { return surface.first(surface.size() - static_cast<std::size_t>(fill_count)); }
  bool is_filling(Index face) const { return static_cast<std::size_t>(face) >= counting().size(); }
};

struct CollapseResult {
  std::vector<Vec3> points;  // of the input; some have moved
  std::vector<Face> triangles;
  std::vector<Index> source;  // the face that each of them was
  std::vector<Index> holder;  // of each face: a triangle of the result that holds some of it
  double deviation = 0;       // bound of the distance between the surface and them, both ways
  std::vector<Index> refusals = std::vector<Index>(static_cast<std::size_t>(Refusal::count));
  Index accepted = 0, moved = 0;
};

// Collapses points onto neighbors, the cheapest first, and moves the remaining points to where their planes meet.
// Preserves topology (components, boundary loops, genus). No face turns over. No point of either surface, or of its
// borders, is farther than the tolerance from the other. About O(n log n), on all cores; the same result whatever
// their number.
CollapseResult collapse(const CollapseInput& input);

}  // namespace bldsimp
