// The standard method on plates with sharp notches, through all kernels that lead to it.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "check.hpp"
#include "mesh/halfedges.hpp"
#include "mesh/weld.hpp"
#include "planar/conform.hpp"
#include "planar/facets.hpp"
#include "planar/outlines.hpp"
#include "planar/retriangulate.hpp"
#include "planar/thin.hpp"

using namespace bldsimp;

namespace {

// A star with spikes of many lengths, pulled up: a closed body whose caps are triangulated.
struct Body {
  std::vector<Vec3> points;
  std::vector<Face> faces;
};

Body star_body(std::mt19937_64& generator, Index spikes) {
  std::uniform_real_distribution<double> tip(200, 1000), notch(50, 150), turn(0, 0.8);
  const Index count = 2 * spikes;
  std::vector<Point2> ring;
  std::vector<Triangulator::Segment> segments;
  for (Index i = 0; i < count; ++i) {
    const double angle = (i + turn(generator)) * 3.14159 / spikes,
                 radius = i % 2 == 0 ? tip(generator) : notch(generator);
    ring.push_back({std::round(radius * std::cos(angle)), std::round(radius * std::sin(angle))});
    segments.push_back({i, (i + 1) % count});
  }
  Triangulator triangulator;
  CHECK(triangulator.run(ring, segments) == Status::done);
  Body body;
  for (const double height : {0.0, 4.0})
    for (const Point2& p : ring) body.points.push_back({p.x, p.y, height});
  for (const auto& [a, b, c] : triangulator.triangles()) {
    body.faces.push_back({a, c, b});
    body.faces.push_back({a + count, b + count, c + count});
  }
  for (const auto& [a, b] : segments) {
    body.faces.push_back({a, b, b + count});
    body.faces.push_back({a, b + count, a + count});
  }
  return body;
}

struct Conforming {
  ConformResult conformed;
  std::size_t given_triangles;
};

Conforming conforming(const Body& body, bool keep_first) {
  const WeldResult welded = weld(body.points, body.faces, 0.0, {});
  const auto points = std::span<const Vec3>(welded.points);
  const auto faces = std::span<const Face>(welded.faces);
  const Halfedges halfedges = pair_halfedges(points, faces, CornerRows{}, 0.0);
  const std::vector<Index> label(faces.size(), 0);
  const Facets facets = find_facets(points, faces, halfedges, label, {0, 0, 0}, {0, 0, 0});
  std::vector<std::uint8_t> keep(facets.planes.size(), 0);
  keep[0] = keep_first;
  const Outlines outlines = trace_outlines(faces, static_cast<Index>(points.size()), halfedges, facets, keep);
  const std::vector<double> limit(outlines.chain_start.size() - 1, 0.0);
  const std::vector<std::uint8_t> kept = thin_chains(points, outlines, limit, outlines.is_chain_end);
  const std::vector<Piece> pieces = lay_pieces(points, outlines, kept);
  const Groups grouped = group_faces(facets);
  std::vector<Index> wanted;
  for (Index f = 0; f < std::ssize(facets.planes); ++f) wanted.push_back(f);
  const std::vector<double> reach(facets.planes.size(), 0.0);
  const FacetParts parts{points, faces, grouped.start, grouped.members, facets.planes, outlines, pieces, kept, reach};
  const Patches patches = retriangulate(parts, wanted, keep);
  return {conform({points, facets.planes, outlines, pieces, patches.triangles, patches.facet_of_triangle, keep}),
          patches.triangles.size()};
}

bool closed(std::span<const Face> triangles) {
  std::map<std::pair<Index, Index>, int> uses;
  for (const Face& t : triangles)
    for (int i = 0; i < 3; ++i) {
      const Index a = t[i], b = t[(i + 1) % 3];
      uses[std::minmax(a, b)] += a < b ? 1 : 1000;
    }
  return std::all_of(uses.begin(), uses.end(), [](const auto& edge) { return edge.second == 1001; });
}

void stars_stay_closed() {
  std::mt19937_64 generator(5);
  std::size_t made = 0;
  for (int round = 0; round < 40; ++round) {
    const Body body = star_body(generator, 3 + round);
    for (const bool keep : {false, true}) {
      const auto [conformed, given] = conforming(body, keep);
      CHECK(closed(conformed.triangles));
      CHECK(conformed.triangles.size() == given + 2 * conformed.made.size());
      CHECK((conformed.facets[0] == Conformity::kept) == keep);
      CHECK(std::count(conformed.facets.begin(), conformed.facets.end(), Conformity::delaunay) ==
            std::ssize(conformed.facets) - keep);
      CHECK(conformed.statistics.by_poles == 0);
      made += conformed.made.size();
    }
  }
  CHECK(made > 1000);
}

void one_triangle_stays() {
  const auto [conformed, given] = conforming({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}, false);
  CHECK(conformed.made.empty() && given == 1);
  CHECK(conformed.triangles.size() == 1);
}

}  // namespace

int main() {
  RUN(stars_stay_closed);
  RUN(one_triangle_stays);
  return check::report();
}
