#include "collapse/holder_normals.hpp"

#include <limits>
#include <tuple>

namespace bldsimp {
namespace {

// Sine of the angle between faces that tell two axes of a box.
constexpr double kSteep = 0.5;
// Share of a body's area that a rim has at most.
constexpr double kMostRim = 0.5;

// A box along the faces of a body; its longest side comes first.
struct OrientedBox {
  Triangle axes;
  std::array<double, 3> sides;

  // The axis that a vector is nearest to.
  std::size_t nearest_axis(Vec3 v) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (std::abs(dot(v, axes[i])) > std::abs(dot(v, axes[best]))) best = i;
    return best;
  }
  // How wide the side is that lies square to an axis.
  double width(std::size_t axis) const { return axis == 2 ? sides[1] : sides[2]; }
};

// The longest edge that only one face has.
Vec3 longest_border(Points points, Faces body) {
  std::vector<Edge> edges;
  for (const auto& [a, b, c] : body)
    for (const auto& [p, q] : {std::minmax(a, b), std::minmax(b, c), std::minmax(c, a)}) edges.push_back({p, q});
  std::sort(edges.begin(), edges.end());
  Vec3 longest{0, 0, 0};
  for_runs(
      edges, [](const Edge& e, const Edge& f) { return e == f; },
      [&](auto same) {
        const Vec3 along = points[same[0][1]] - points[same[0][0]];
        if (same.size() == 1 && dot(along, along) > dot(longest, longest)) longest = along;
      });
  return longest;
}

// Square to the largest face, to the largest one that is steep to it, and to both. A flat body has none of those: then
// its longest border tells the second axis.
Triangle find_axes(Points points, Faces body) {
  Vec3 largest{0, 0, 0}, steepest{0, 0, 0};
  for (const Face& f : body) {
    const Vec3 own = area_vector(corners_of(f, points));
    if (dot(own, own) > dot(largest, largest)) largest = own;
  }
  const Vec3 z = normalize(largest);
  for (const Face& f : body) {
    const Vec3 own = area_vector(corners_of(f, points)), across = own - dot(own, z) * z;
    if (length(across) > kSteep * length(own) && dot(across, across) > dot(steepest, steepest)) steepest = across;
  }
  if (steepest == Vec3{0, 0, 0}) {
    const Vec3 border = longest_border(points, body);
    steepest = border - dot(border, z) * z;
  }
  const Vec3 x = steepest == Vec3{0, 0, 0} ? square_to(z) : normalize(steepest);
  return {x, cross(z, x), z};
}

OrientedBox find_oriented_box(Points points, Faces body) {
  OrientedBox box{find_axes(points, body), {}};
  std::array<std::pair<double, Vec3>, 3> sides;
  for (std::size_t i = 0; i < 3; ++i) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Face& f : body)
      for (const Index p : f) {
        const double at = dot(points[p], box.axes[i]);
        low = std::min(low, at), high = std::max(high, at);
      }
    sides[i] = {high - low, box.axes[i]};
  }
  std::stable_sort(sides.begin(), sides.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  for (std::size_t i = 0; i < 3; ++i) std::tie(box.sides[i], box.axes[i]) = sides[i];
  return box;
}

// Up to which width faces are narrow. The rim of a panel may be two limits wide, since something on either side of it
// can hold it. Where faces that wide are most of the body, they are no rim.
double find_narrow(const OrientedBox& box, std::span<const Vec3> areas, double limit) {
  double all = 0, wide = 0;
  for (const Vec3& own : areas) {
    const double width = box.width(box.nearest_axis(own)), area = length(own);
    all += area;
    if (limit < width && width <= 2 * limit) wide += area;
  }
  return wide > kMostRim * all ? limit : 2 * limit;
}

}  // namespace

std::vector<Vec3> find_holder_normals(Points points, Faces body, double limit) {
  std::vector<Vec3> normals(body.size(), Vec3{0, 0, 0}), areas;
  for (const Face& f : body) areas.push_back(area_vector(corners_of(f, points)));
  if (std::all_of(areas.begin(), areas.end(), [](Vec3 own) { return own == Vec3{0, 0, 0}; })) return normals;
  const OrientedBox box = find_oriented_box(points, body);
  if (box.sides[0] <= 2 * limit) return normals;
  const double narrow = find_narrow(box, areas, limit);
  for (std::size_t f = 0; f < body.size(); ++f)
    if (box.width(box.nearest_axis(areas[f])) > narrow) normals[f] = normalize(areas[f]);
  return normals;
}

}  // namespace bldsimp
