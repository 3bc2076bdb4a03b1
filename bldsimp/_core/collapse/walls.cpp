#include "collapse/walls.hpp"

namespace bldsimp {
namespace {

std::vector<Face> select_faces(Faces faces, std::span<const FlatFace> flat) {
  std::vector<Face> some;
  for (const FlatFace& one : flat) some.push_back(faces[one.face]);
  return some;
}

}  // namespace

Walls::Walls(Points points, Faces faces, std::span<const FlatFace> flat, double tolerance)
    : flat_(flat.begin(), flat.end()), tolerance_(tolerance), tree_(points, select_faces(faces, flat)) {}

std::optional<double> Walls::measure_leaning(const Triangle& t, Vec3 origin) const {
  const Vec3 middle = centroid(t) + origin, twice = area_vector(t);
  std::optional<double> nearest;
  const bool leans = tree_.visit_near(middle, tolerance_, [&](Index place) {
    const double squared = tree_.triangle(place).squared_distance(middle);
    nearest = std::min(squared, nearest.value_or(squared));
    const FlatFace& wall = flat_[tree_.order()[place]];
    return length(cross(wall.normal, twice)) > wall.sine * length(twice);
  });
  if (!leans || !nearest) return {};
  return std::sqrt(*nearest);
}

}  // namespace bldsimp
