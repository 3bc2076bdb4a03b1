#include "collapse/borders.hpp"

#include <unordered_map>

#include "mesh/edges.hpp"

namespace bldsimp {
namespace {

struct HashFace {
  std::size_t operator()(const Face& f) const {
    std::uint64_t h = 0;
    for (const Index i : f) h = (h ^ static_cast<std::uint32_t>(i)) * 0x9e3779b97f4a7c15u, h ^= h >> 29;
    return h;
  }
};

}  // namespace

DistinctFaces merge_copies(Faces faces) {
  std::unordered_map<Face, Index, HashFace> seen;
  seen.reserve(2 * faces.size());
  DistinctFaces single;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto [at, added] = seen.try_emplace(sort_corners(faces[f]), static_cast<Index>(single.faces.size()));
    if (added) {
      single.faces.push_back(faces[f]);
      single.index.push_back(static_cast<Index>(f));
      single.copy.push_back(-1);
    } else {
      single.copy[at->second] = static_cast<Index>(f);
    }
  }
  return single;
}

std::vector<Labels> pair_labels(const DistinctFaces& single, Indices label) {
  std::vector<Labels> found;
  found.reserve(single.faces.size());
  for (std::size_t f = 0; f < single.faces.size(); ++f)
    found.push_back({label[single.index[f]], single.copy[f] < 0 ? -1 : label[single.copy[f]]});
  return found;
}

// Edges at which the surface ends or parts, and edges between labels.
std::vector<BorderEdge> find_border_edges(Faces faces, std::size_t points, std::span<const Labels> labels) {
  std::vector<BorderEdge> found;
  const auto count = static_cast<Index>(points);
  EdgeBuckets(faces, count).visit(0, count, [&](Indices edge) {
    if (edge.size() == 2 && labels[edge[0] / 3] == labels[edge[1] / 3]) return;
    const bool open = edge.size() == 1 && labels[edge[0] / 3][1] < 0;
    found.push_back({{origin(faces, edge[0]), target(faces, edge[0])}, open ? 0 : edge.size() == 2 ? 1 : 2, {}});
    for (const Index h : edge) found.back().labels.push_back(labels[h / 3]);
    std::sort(found.back().labels.begin(), found.back().labels.end());
  });
  return found;
}

std::vector<Face> flatten_edges(std::span<const BorderEdge> edges, int kind) {
  std::vector<Face> flat;
  for (const BorderEdge& e : edges)
    if (e.kind == kind) flat.push_back({e.ends[0], e.ends[1], e.ends[1]});
  return flat;
}

}  // namespace bldsimp
