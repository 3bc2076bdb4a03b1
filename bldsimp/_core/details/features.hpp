// Remove details as wholes: recesses, passages, sills, chimneys, steps, and loops of open edges.
#pragma once

#include "details/feature_candidate.hpp"
#include "mesh/rounding.hpp"

namespace bldsimp {

struct FeatureInput {
  Points points;
  Faces faces;
  Indices label;
  Indices part;         // of each face: caps use points of their own part only
  Flags has_many_rows;  // points where that matters, since the file has several rows there
  Flags stays;          // faces that may not go
  Flags left_out;       // faces that have gone already, and count all the same
  double limit;         // how far anything may move
  double flat;          // facets are flat within this
  Rounding rounding;
  bool keep_topology;    // passages and open edges stay
  Index most_triangles;  // that may be left
};

struct FeatureRemoval {
  std::vector<Vec3> points;  // of the input; some have moved
  std::vector<std::uint8_t> left_out;
  std::vector<Face> faces;  // that took the place of those left out
  std::vector<Index> parent;
  // Of each feature that went: its least and its greatest coordinates, its kind, and a face that went or was beside it.
  std::vector<Vec3> boxes;
  std::vector<std::uint8_t> kinds;
  std::vector<Index> places, triangles;
  Index kept_by_label = 0;  // candidates that stay since the facets around have several labels
};

// A feature is a set of facets of which every border loop can be closed in the planes of the facets around it. It goes
// where the caps are within the limit of the given faces, these within the limit of what is left with the caps, and no
// cap crosses what is there. The number of points and triangles never grows, nor does that of open edges. The same
// result whatever the number of threads.
FeatureRemoval remove_features(const FeatureInput& input);

}  // namespace bldsimp
