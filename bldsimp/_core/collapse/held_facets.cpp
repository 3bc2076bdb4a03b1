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
// A smaller facet is no wall. Its area divided by its length counts, in tolerances.
constexpr double kLeastWall = 1;
// A face of less than this share of its component is hardly noticed.
constexpr double kNoticed = 1e-3;
// Sine of one degree: less is hardly seen.
constexpr double kLeaning = 0.0175;

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

  // Whether more of the border of a facet is sharp or open than not.
  bool has_sharp_border(Index facet) const {
    double sharp = 0, all = 0;
    visit_border(facet, [&](Index, double size, bool is_sharp) {
      all += size;
      if (is_sharp) sharp += size;
    });
    return sharp >= kSharpShare * all;
  }

  // Whether a facet that has a sharp border keeps its plane.
  bool holds(Index facet) const {
    if (is_large_[facet]) return true;
    std::map<Index, double> common;  // length of sharp edges with large facets
    visit_border(facet, [&](Index other, double size, bool is_sharp) {
      if (is_sharp && other >= 0 && is_wall_[other]) common[other] += size;
    });
    return std::any_of(common.begin(), common.end(), [&](const auto& one) { return one.second > kLong * tolerance_; });
  }

 private:
  // Calls edge(facet across or -1, length, whether it is sharp or open).
  template <class Edge>
  void visit_border(Index facet, Edge edge) const {
    for (const Loop& loop : graph_.find_loops(std::array{facet}))
      for (const LoopEdge& e : loop) {
        const Index other = e.outside < 0 ? -1 : graph_.facet_of(e.outside);
        edge(other, measure_edge(graph_, e), other < 0 || is_sharp(graph_, facet, other));
      }
  }

  const FacetGraph& graph_;
  double tolerance_;
  std::vector<bool> is_large_, is_wall_;
};

std::vector<double> measure_noticed(Points points, Faces faces) {
  const auto component = find_components(faces, static_cast<Index>(points.size()));
  std::vector<double> area(faces.size()), noticed;  // at the least face of each component
  for (std::size_t f = 0; f < faces.size(); ++f)
    area[component[f]] += length(area_vector(corners_of(faces[f], points))) / 2;
  for (std::size_t f = 0; f < faces.size(); ++f) noticed.push_back(kNoticed * area[component[f]]);
  return noticed;
}

}  // namespace

HeldFacets find_held_facets(Points points, Faces faces, Indices label, double tolerance) {
  HeldFacets held{std::vector<Index>(faces.size(), -1), {}, {}, measure_noticed(points, faces)};
  if (faces.empty()) return held;
  const Vec3 middle = points[points.size() / 2];
  const FacetGraph graph(about_middle(points), faces, label, kFlat * tolerance);
  const PlaneHolder holder(graph, tolerance);
  for (Index k = 0; k < graph.facet_count(); ++k) {
    if (!holder.has_sharp_border(k)) continue;
    const FacetShape& own = graph.shape(k);
    if (graph.is_wider(k, kLeastWall * tolerance)) {
      // What is flat within some height tells less of its normal the narrower it is.
      const double sine = std::max(kLeaning, graph.flat() * 2 * own.radius / own.area);
      for (const Index f : graph.faces_of(k)) held.flat.push_back({f, own.normal, sine});
    }
    if (!holder.holds(k)) continue;
    for (const Index f : graph.faces_of(k)) held.plane_of_face[f] = static_cast<Index>(held.planes.size());
    held.planes.push_back({own.normal, own.offset + dot(own.normal, middle)});
  }
  return held;
}

}  // namespace bldsimp
