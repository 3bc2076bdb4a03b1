// Sum squared distances to weighted planes.
#pragma once

#include "mesh/eigen.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

// p A p + 2 b p + c.
class Quadric {
 public:
  // The plane n p + d = 0.
  void add(Vec3 n, double d, double weight) {
    a_[0] += weight * n.x * n.x, a_[1] += weight * n.x * n.y, a_[2] += weight * n.x * n.z;
    a_[3] += weight * n.y * n.y, a_[4] += weight * n.y * n.z, a_[5] += weight * n.z * n.z;
    b_ = b_ + weight * d * n;
    c_ += weight * d * d;
  }
  void add(const Quadric& q) {
    for (std::size_t i = 0; i < 6; ++i) a_[i] += q.a_[i];
    b_ = b_ + q.b_;
    c_ += q.c_;
  }
  double at(Vec3 p) const { return dot(p, times(p) + 2 * b_) + c_; }
  double weight() const { return a_[0] + a_[3] + a_[5]; }

  // Where the planes meet, in the directions in which they tell more than `share` of the most; else where p is.
  Vec3 lowest(Vec3 p, double share) const {
    const EigenSystem own = decompose(a_);
    const double most = std::max({own.values[0], own.values[1], own.values[2]});
    const Vec3 slope = times(p) + b_;
    for (std::size_t i = 0; i < 3; ++i)
      if (own.values[i] > share * most) p = p - dot(slope, own.vectors[i]) / own.values[i] * own.vectors[i];
    return p;
  }

 private:
  Vec3 times(Vec3 p) const {
    return {a_[0] * p.x + a_[1] * p.y + a_[2] * p.z, a_[1] * p.x + a_[3] * p.y + a_[4] * p.z,
            a_[2] * p.x + a_[4] * p.y + a_[5] * p.z};
  }
  std::array<double, 6> a_{};  // xx xy xz yy yz zz
  Vec3 b_{0, 0, 0};
  double c_ = 0;
};

}  // namespace bldsimp
