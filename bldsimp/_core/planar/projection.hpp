// Project the plane of a facet for the triangulator.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

// Drops the axis along which a plane's normal is greatest; a facet stays counter-clockwise.
class Projection {
 public:
  Projection(Vec3 normal, Vec3 origin) : origin_(origin) {
    const std::array<double, 3> n{normal.x, normal.y, normal.z};
    w_ = std::abs(n[2]) >= std::abs(n[0]) && std::abs(n[2]) >= std::abs(n[1]) ? 2
         : std::abs(n[0]) >= std::abs(n[1])                                   ? 0
                                                                              : 1;
    u_ = (w_ + 1) % 3;
    v_ = (w_ + 2) % 3;
    if (n[w_] < 0) std::swap(u_, v_);
    slope_u_ = n[u_] / n[w_];
    slope_v_ = n[v_] / n[w_];
  }

  Point2 operator()(Vec3 p) const { return {coordinate(p, u_), coordinate(p, v_)}; }

  // Squared length, in the plane, of the way from the origin: the Delaunay lift of the plane.
  double lift(Vec3 p) const {
    const double u = coordinate(p, u_) - coordinate(origin_, u_), v = coordinate(p, v_) - coordinate(origin_, v_);
    const double w = slope_u_ * u + slope_v_ * v;
    return u * u + v * v + w * w;
  }

  double twice_area(Vec3 a, Vec3 b, Vec3 c) const {
    return (coordinate(b, u_) - coordinate(a, u_)) * (coordinate(c, v_) - coordinate(a, v_)) -
           (coordinate(b, v_) - coordinate(a, v_)) * (coordinate(c, u_) - coordinate(a, u_));
  }

 private:
  static double coordinate(Vec3 p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }
  Vec3 origin_;
  int u_, v_, w_;
  double slope_u_, slope_v_;
};

}  // namespace bldsimp
