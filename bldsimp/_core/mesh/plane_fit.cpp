#include "mesh/plane_fit.hpp"

#include "mesh/eigen.hpp"

namespace bldsimp {

Vec3 Moments::normal() const {
  const Vec3 g = (1 / area_) * first_;
  const EigenSystem found =
      decompose({second_[0] / area_ - g.x * g.x, second_[1] / area_ - g.x * g.y, second_[2] / area_ - g.x * g.z,
                 second_[3] / area_ - g.y * g.y, second_[4] / area_ - g.y * g.z, second_[5] / area_ - g.z * g.z});
  int least = 0;
  for (int k = 1; k < 3; ++k)
    if (found.values[k] < found.values[least]) least = k;
  return found.vectors[least];
}

}  // namespace bldsimp
