#include "plane_fit.hpp"

#include <utility>

namespace bldsimp {

// Cyclic Jacobi rotations: a handful of sweeps brings a 3 x 3 matrix to rounding.
Vec3 Moments::normal() const {
  const Vec3 g = (1 / area_) * first_;
  double m[3][3] = {{second_[0] / area_ - g.x * g.x, second_[1] / area_ - g.x * g.y, second_[2] / area_ - g.x * g.z},
                    {0, second_[3] / area_ - g.y * g.y, second_[4] / area_ - g.y * g.z},
                    {0, 0, second_[5] / area_ - g.z * g.z}};
  m[1][0] = m[0][1];
  m[2][0] = m[0][2];
  m[2][1] = m[1][2];
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int sweep = 0; sweep < 30; ++sweep) {
    if (m[0][1] == 0 && m[0][2] == 0 && m[1][2] == 0) break;
    for (const auto& [p, q] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
      if (m[p][q] == 0) continue;
      const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
      const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
      const double c = 1 / std::sqrt(t * t + 1), s = t * c;
      const auto rotate = [c, s](double& x, double& y) {
        const double old = x;
        x = c * old - s * y;
        y = s * old + c * y;
      };
      for (auto& row : m) rotate(row[p], row[q]);
      for (int k = 0; k < 3; ++k) rotate(m[p][k], m[q][k]);
      m[p][q] = m[q][p] = 0;
      for (auto& row : v) rotate(row[p], row[q]);
    }
  }
  int least = 0;
  for (int k = 1; k < 3; ++k)
    if (m[k][k] < m[least][least]) least = k;
  const Vec3 n{v[0][least], v[1][least], v[2][least]};
  return (1 / length(n)) * n;
}

}  // namespace bldsimp
