// Make small meshes for tests, from fixed seeds.
#pragma once

#include <algorithm>
#include <array>
#include <random>
#include <utility>
#include <vector>

#include "mesh/vec3.hpp"

namespace shapes {

using namespace bldsimp;
using Random = std::mt19937_64;

struct Soup {
  std::vector<Vec3> points;
  std::vector<Face> faces;

  Index add(Vec3 p) {
    points.push_back(p);
    return static_cast<Index>(points.size()) - 1;
  }
  void add_quad(Index a, Index b, Index c, Index d) {
    faces.push_back({a, b, c});
    faces.push_back({a, c, d});
  }
};

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline Index below(Random& random, Index end) { return std::uniform_int_distribution<Index>(0, end - 1)(random); }

// A box between two corners; faces look outwards.
inline Soup box(Vec3 low, Vec3 high) {
  Soup soup;
  for (int i = 0; i < 8; ++i) soup.add({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
  for (const auto& [a, b, c, d] : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
                                   std::array{2, 6, 7, 3}, std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}})
    soup.add_quad(a, b, c, d);
  return soup;
}

// The surface of a block of cells of which some are missing: walls with windows, recesses and passages; where only
// edges or corners of cells touch, more than two faces meet. Rows of the file are shared in `share` of all corners.
inline Soup block_with_windows(Random& random, Index side, double missing, double share) {
  std::vector<bool> solid;
  for (Index i = 0; i < side * side * side; ++i) solid.push_back(uniform(random, 0, 1) >= missing);
  const auto is_solid = [&](std::array<Index, 3> cell) {
    for (const Index i : cell)
      if (i < 0 || i >= side) return false;
    return bool{solid[(cell[0] * side + cell[1]) * side + cell[2]]};
  };
  Soup soup;
  const Index corners = side + 1;
  std::vector<Index> row_of_corner(corners * corners * corners, -1);
  const auto row = [&](const std::array<Index, 3>& p) {
    Index& known = row_of_corner[(p[0] * corners + p[1]) * corners + p[2]];
    if (known >= 0 && uniform(random, 0, 1) < share) return known;
    return known = soup.add({1.0 * p[0], 1.0 * p[1], 1.0 * p[2]});
  };
  for (Index cell = 0; cell < side * side * side; ++cell) {
    const std::array<Index, 3> low{cell / side / side, cell / side % side, cell % side};
    if (!is_solid(low)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const Index way : {0, 1}) {
        auto beyond = low;
        beyond[axis] += way == 1 ? 1 : -1;
        if (is_solid(beyond)) continue;
        std::array<Index, 4> quad;
        for (std::size_t i = 0; i < 4; ++i) {
          auto corner = low;
          corner[axis] += way;
          corner[(axis + 1) % 3] += i == 1 || i == 2;
          corner[(axis + 2) % 3] += i >= 2;
          quad[i] = row(corner);
        }
        if (way == 0) std::swap(quad[1], quad[3]);
        const std::size_t turn = random() % 2;
        soup.add_quad(quad[turn], quad[turn + 1], quad[(turn + 2) % 4], quad[(turn + 3) % 4]);
      }
  }
  return soup;
}

// A grid with noise, `gone` of whose faces are missing.
inline Soup noisy_sheet(Random& random, Index side, double noise, double gone) {
  Soup soup;
  const auto off = [&] { return uniform(random, -noise, noise); };
  for (Index i = 0; i < side * side; ++i) soup.add({i % side + off(), 1.0 * (i / side) + off(), off()});
  for (Index y = 0; y + 1 < side; ++y)
    for (Index x = 0; x + 1 < side; ++x) {
      const Index p = y * side + x;
      if (uniform(random, 0, 1) >= gone) soup.faces.push_back({p, p + 1, p + side + 1});
      if (uniform(random, 0, 1) >= gone) soup.faces.push_back({p, p + side + 1, p + side});
    }
  return soup;
}

// Cuts some faces at a point near an edge, so that needles come about, and open edges where the neighbor is not cut.
inline void add_needles(Random& random, Soup& soup, int count, double off) {
  for (int i = 0; i < count && !soup.faces.empty(); ++i) {
    const auto f = static_cast<std::size_t>(below(random, static_cast<Index>(soup.faces.size())));
    const auto [a, b, c] = soup.faces[f];
    const double share = uniform(random, 0.1, 0.9);
    const Vec3 noise{uniform(random, -off, off), uniform(random, -off, off), uniform(random, -off, off)};
    const Index m = soup.add((1 - share) * soup.points[a] + share * soup.points[b] + noise);
    soup.faces[f] = {a, m, c};
    soup.faces.push_back({m, b, c});
    if (random() % 2) soup.faces.push_back({a, b, m});
  }
}

// Repeats some faces, some of them the other way round or without area.
inline void add_copies(Random& random, Soup& soup, int count) {
  for (int i = 0; i < count && !soup.faces.empty(); ++i) {
    auto [a, b, c] = soup.faces[static_cast<std::size_t>(below(random, static_cast<Index>(soup.faces.size())))];
    if (random() % 2) std::swap(b, c);
    if (random() % 4 == 0) c = a;
    soup.faces.push_back({b, c, a});
  }
}

// Turns some faces over.
inline void turn_some(Random& random, Soup& soup, double share) {
  for (Face& face : soup.faces)
    if (uniform(random, 0, 1) < share) std::swap(face[1], face[2]);
}

inline void append(Soup& soup, const Soup& other, Vec3 shift) {
  const auto before = static_cast<Index>(soup.points.size());
  for (const Vec3& p : other.points) soup.add(p + shift);
  for (const auto& [a, b, c] : other.faces) soup.faces.push_back({a + before, b + before, c + before});
}

// Rotates by an angle about an axis that is parallel to none of the coordinates.
inline void rotate(Soup& soup, double angle) {
  const Vec3 axis = (1 / std::sqrt(14.0)) * Vec3{1, 2, 3};
  const double c = std::cos(angle), s = std::sin(angle);
  for (Vec3& p : soup.points) p = c * p + s * cross(axis, p) + ((1 - c) * dot(axis, p)) * axis;
}

inline void add_noise(Random& random, Soup& soup, double noise) {
  for (Vec3& p : soup.points)
    p = p + Vec3{uniform(random, -noise, noise), uniform(random, -noise, noise), uniform(random, -noise, noise)};
}

}  // namespace shapes
