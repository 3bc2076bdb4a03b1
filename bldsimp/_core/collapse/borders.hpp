// Find the edges at which a surface ends, or two labels meet.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

inline Face sort_corners(Face f) {
  std::sort(f.begin(), f.end());
  return f;
}

// Faces that are copies of one another but for their winding count as one.
struct DistinctFaces {
  std::vector<Face> faces;
  std::vector<Index> index, copy;  // of the given faces: the one, and the other or -1
};

DistinctFaces merge_copies(Faces faces);

using Labels = IndexPair;  // of a face and of its copy, -1 without

std::vector<Labels> pair_labels(const DistinctFaces& single, Indices label);

// Kinds are kept apart: open edges, edges between labels, and the rest (of more than two faces, or where a sheet with
// two sides ends).
inline constexpr int edge_kinds = 3;

struct BorderEdge {
  Edge ends;
  int kind;
  std::vector<Labels> labels;  // of its faces
};

// Edges of other than two faces, and edges between labels.
std::vector<BorderEdge> find_border_edges(Faces faces, std::size_t points, std::span<const Labels> labels);

// Edges of one kind as faces without area.
std::vector<Face> flatten_edges(std::span<const BorderEdge> edges, int kind);

}  // namespace bldsimp
