// Fit planes by area-weighted moments, without any library, so that every machine gets the same bits.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

// Area-weighted moments of a triangle soup about a fixed origin; adding two is O(1).
class Moments {
 public:
  explicit Moments(Vec3 origin) : origin_(origin) {}

  void add(Vec3 a, Vec3 b, Vec3 c) {
    a = a - origin_;
    b = b - origin_;
    c = c - origin_;
    const double area = length(cross(b - a, c - a)) / 2;
    const Vec3 s = a + b + c;
    area_ += area;
    first_ = first_ + (area / 3) * s;
    const double w = area / 12;
    second_[0] += w * (a.x * a.x + b.x * b.x + c.x * c.x + s.x * s.x);
    second_[1] += w * (a.x * a.y + b.x * b.y + c.x * c.y + s.x * s.y);
    second_[2] += w * (a.x * a.z + b.x * b.z + c.x * c.z + s.x * s.z);
    second_[3] += w * (a.y * a.y + b.y * b.y + c.y * c.y + s.y * s.y);
    second_[4] += w * (a.y * a.z + b.y * b.z + c.y * c.z + s.y * s.z);
    second_[5] += w * (a.z * a.z + b.z * b.z + c.z * c.z + s.z * s.z);
  }

  double area() const { return area_; }
  // Unit normal of the plane with the least area-weighted squared distance; its sign is arbitrary.
  // Needs a positive area.
  Vec3 normal() const;

 private:
  Vec3 origin_;
  double area_ = 0;
  Vec3 first_{0, 0, 0};
  std::array<double, 6> second_{};  // xx xy xz yy yz zz
};

}  // namespace bldsimp
