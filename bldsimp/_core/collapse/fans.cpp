#include "collapse/fans.hpp"

#include <limits>

namespace bldsimp {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
// What is outside by less than this share counts as inside.
constexpr double kRounding = 1e-9;

// A point seen from above: place and height.
struct Projected {
  double x, y, z;
};

double across(const Projected& p, const Projected& q) { return p.x * q.y - p.y * q.x; }
Projected minus(const Projected& p, const Projected& q) { return {p.x - q.x, p.y - q.y, p.z - q.z}; }

// Distance in height between the spokes from the origin to p and from t to q where they cross, 0 where they do not.
double apart_at_crossing(const Projected& p, const Projected& t, const Projected& q) {
  const Projected way = minus(q, t);
  const double turn = across(p, way);
  const double along = across(t, way), beside = across(t, p);  // both divided by `turn` are shares
  const double size = std::abs(turn), slack = kRounding * size, sign = turn < 0 ? -1 : 1;
  if (size == 0 || sign * along < -slack || sign * along > size + slack || sign * beside < -slack ||
      sign * beside > size + slack)
    return 0;
  return std::abs(along / turn * p.z - t.z - beside / turn * way.z);
}

// Height of the triangle between the origin and two points above a place that is inside of it, less the place's own, as
// it is; 0 where it is outside.
double apart_inside(const Projected& place, const Projected& p, const Projected& q) {
  const double area = across(p, q), u = across(place, q), v = across(p, place), slack = kRounding * area;
  if (u < -slack || v < -slack || u + v > area + slack) return 0;
  return std::abs((u * p.z + v * q.z) / area - place.z);
}

}  // namespace

double bound_fan_distance(Vec3 from, Vec3 to, std::span<const std::array<Vec3, 2>> ring) {
  Vec3 normal{0, 0, 0};
  for (const auto& [p, q] : ring) normal = normal + cross(p - from, q - from);
  const double size = length(normal);
  if (size == 0) return kFar;
  const Vec3 z = (1 / size) * normal;
  const Vec3 x = square_to(z), y = cross(z, x);
  const auto project = [&](Vec3 p) { return Projected{dot(p - from, x), dot(p - from, y), dot(p - from, z)}; };
  const Projected target = project(to);
  double most = 0;
  int windings = 0;
  std::vector<std::array<Projected, 2>> edges;
  for (const auto& [p, q] : ring) edges.push_back({project(p), project(q)});
  for (const auto& [p, q] : edges) {
    if (!(across(p, q) > 0)) return kFar;
    windings += p.y <= 0 && q.y > 0;
    most = std::max(most, apart_inside(target, p, q));
  }
  if (windings != 1) return kFar;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto& [p, q] = edges[i];
    if (ring[i][0] == to || ring[i][1] == to) continue;
    const Projected own_p = minus(p, target), own_q = minus(q, target);
    if (!(across(own_p, own_q) > 0)) return kFar;
    most = std::max(most, apart_inside(minus({0, 0, 0}, target), own_p, own_q));
    for (const auto& [spoke, next] : edges)
      most = std::max({most, apart_at_crossing(spoke, target, p), apart_at_crossing(spoke, target, q)});
  }
  return most;
}

}  // namespace bldsimp
