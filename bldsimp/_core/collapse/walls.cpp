#include "collapse/walls.hpp"

namespace bldsimp {
namespace {

std::vector<Index> list_faces(std::span<const FlatFace> flat) {
  std::vector<Index> faces;
  for (const FlatFace& one : flat) faces.push_back(one.face);
  return faces;
}

}  // namespace

Walls::Walls(Points points, Faces faces, std::span<const FlatFace> flat, double tolerance)
    : tolerance_(tolerance), tree_(points, faces, list_faces(flat)) {
  std::vector<Index> place(faces.size(), -1);
  for (std::size_t i = 0; i < flat.size(); ++i) place[flat[i].face] = static_cast<Index>(i);
  for (const Index f : tree_.order()) {
    const auto [a, b, c] = corners_of(faces[f], points);
    walls_.push_back({FramedTriangle(a, b, c), flat[place[f]]});
  }
}

std::optional<double> Walls::measure_leaning(const Triangle& t, Vec3 origin) const {
  const Vec3 twice = area_vector(t), normal = (1 / length(twice)) * twice;
  const Vec3 middle = centroid(t) + origin, around{tolerance_, tolerance_, tolerance_};
  double nearest = tolerance_ * tolerance_;
  bool any = false;
  const bool leans = tree_.visit(Box{middle - around, middle + around}, [&](Index i) {
    const Wall& wall = walls_[i];
    const double squared = wall.triangle.squared_distance(middle);
    if (squared > tolerance_ * tolerance_) return true;
    any = true;
    nearest = std::min(nearest, squared);
    return length(cross(wall.flat.normal, normal)) > wall.flat.sine;
  });
  if (!leans || !any) return {};
  return std::sqrt(nearest);
}

}  // namespace bldsimp
