#include "collapse/held_facets.hpp"

#include <map>

#include "details/facet_graph.hpp"

namespace bldsimp {
namespace {

// A facet is flat where it is no wider than this share of the tolerance to either side.
constexpr double kFlat = 0.05;
// Narrow facets keep their planes beside a facet whose area divided by its length is over this many tolerances.
constexpr double kWall = 6;
// Cosine of 25 degrees: noise hardly makes sharper edges.
constexpr double kSharp = 0.906;
// More than this share of its border is sharp.
constexpr double kSharpShare = 0.5;
// An edge is long beyond this many tolerances.
constexpr double kLong = 2;

bool is_sharp(const FacetGraph& graph, Index facet, Index other) {
  return dot(graph.shape(facet).normal, graph.shape(other).normal) < kSharp;
}

double measure_edge(const FacetGraph& graph, const LoopEdge& e) {
  return length(graph.points()[e.to] - graph.points()[e.from]);
}

// Tells which facets keep their planes: large ones, and narrow ones beside much larger ones. All have sharp borders.
class PlaneHolder {
 public:
  PlaneHolder(const FacetGraph& graph, double tolerance) : graph_(graph), tolerance_(tolerance) {
    for (Index k = 0; k < graph.facet_count(); ++k) {
      is_large_.push_back(graph.is_wider(k, large_facet * tolerance));
      is_wall_.push_back(graph.is_wider(k, kWall * tolerance));
    }
  }

  bool holds(Index facet) const {
    double sharp = 0, all = 0;
    std::map<Index, double> common;  // length of sharp edges with large facets
    for (const Loop& loop : graph_.find_loops(std::array{facet}))
      for (const LoopEdge& e : loop) {
        const double size = measure_edge(graph_, e);
        const Index other = e.outside < 0 ? -1 : graph_.facet_of(e.outside);
        all += size;
        if (other >= 0 && !is_sharp(graph_, facet, other)) continue;
        sharp += size;
        if (other >= 0 && is_wall_[other]) common[other] += size;
      }
    if (sharp < kSharpShare * all) return false;
    return is_large_[facet] ||
           std::any_of(common.begin(), common.end(), [&](const auto& one) { return one.second > kLong * tolerance_; });
  }

 private:
  const FacetGraph& graph_;
  double tolerance_;
  std::vector<bool> is_large_, is_wall_;
};

}  // namespace

HeldFacets find_held_facets(Points points, Faces faces, Indices label, double tolerance) {
  HeldFacets held{std::vector<Index>(faces.size(), -1), {}};
  if (faces.empty()) return held;
  const Vec3 middle = points[points.size() / 2];
  const FacetGraph graph(about_middle(points), faces, label, kFlat * tolerance);
  const PlaneHolder holder(graph, tolerance);
  for (Index k = 0; k < graph.facet_count(); ++k) {
    if (!holder.holds(k)) continue;
    const FacetShape& own = graph.shape(k);
    for (const Index f : graph.faces_of(k)) held.plane_of_face[f] = static_cast<Index>(held.planes.size());
    held.planes.push_back({own.normal, own.offset + dot(own.normal, middle)});
  }
  return held;
}

}  // namespace bldsimp
