#include "mesh/eigen.hpp"

namespace bldsimp {

// Cyclic Jacobi rotations: a handful of sweeps brings a 3 x 3 matrix to rounding.
EigenSystem decompose(const std::array<double, 6>& matrix) {
  const auto& [xx, xy, xz, yy, yz, zz] = matrix;
  double m[3][3] = {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
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
  EigenSystem found;
  for (int k = 0; k < 3; ++k) {
    const Vec3 n{v[0][k], v[1][k], v[2][k]};
    found.values[k] = m[k][k];
    found.vectors[k] = (1 / length(n)) * n;
  }
  return found;
}

}  // namespace bldsimp
