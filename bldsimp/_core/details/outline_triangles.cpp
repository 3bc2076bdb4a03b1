#include "details/outline_triangles.hpp"

#include "planar/projection.hpp"

namespace bldsimp {

std::optional<std::vector<Face>> triangulate_outline(Triangulator& triangulator, Vec3 normal,
                                                     std::span<const Edge> edges, Indices points, Points places,
                                                     double rounding) {
  if (points.empty()) return {};
  const Projection projection(normal, places[0]);
  std::vector<Point2> flat;
  std::vector<double> lift;
  for (const Vec3& p : places) flat.push_back(projection(p)), lift.push_back(projection.lift(p));
  std::vector<Triangulator::Segment> segments;
  double area = 0;
  for (const auto& ends : edges) {
    Triangulator::Segment segment;
    for (std::size_t i = 0; i < 2; ++i)
      segment[i] = static_cast<Index>(std::lower_bound(points.begin(), points.end(), ends[i]) - points.begin());
    segments.push_back(segment);
    area += projection.twice_area(places[0], places[segment[0]], places[segment[1]]);
  }
  if (!(area > 0)) return {};
  TriangulateOptions options;
  options.lift = lift.data();
  if (triangulator.run(flat, segments, options) != Status::done || triangulator.pieces().size() != segments.size())
    return {};
  const double enough = std::max(2 * rounding, 1e-9 * area);
  std::vector<Face> faces;
  for (const auto& [a, b, c] : triangulator.triangles()) {
    area -= projection.twice_area(places[a], places[b], places[c]);
    faces.push_back({points[a], points[b], points[c]});
  }
  if (std::abs(area) > enough) return {};
  return faces;
}

}  // namespace bldsimp
