// Make surfaces of blocks of cells: boxes with windows, recesses, sills and passages of any width.
#pragma once

#include <map>

#include "shapes.hpp"

namespace shapes {

// Which cells of a grid are solid. `lines` are the places of the planes between the cells, along each axis.
struct Cells {
  std::array<std::vector<double>, 3> lines;
  std::vector<bool> solid;

  explicit Cells(const std::array<std::vector<double>, 3>& planes)
      : lines(planes), solid(static_cast<std::size_t>(count(0) * count(1) * count(2)), false) {}

  Index count(std::size_t axis) const { return static_cast<Index>(lines[axis].size()) - 1; }
  bool is_solid(const std::array<Index, 3>& cell) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (cell[axis] < 0 || cell[axis] >= count(axis)) return false;
    return solid[place(cell)];
  }
  // Makes the cells from `low` to the one before `high` solid or empty.
  void fill(const std::array<Index, 3>& low, const std::array<Index, 3>& high, bool is) {
    for (Index x = low[0]; x < high[0]; ++x)
      for (Index y = low[1]; y < high[1]; ++y)
        for (Index z = low[2]; z < high[2]; ++z) solid[place({x, y, z})] = is;
  }
  // The surface, two triangles for each side of a cell; points are shared, but for cells that touch in an edge only.
  Soup surface() const {
    Soup soup;
    std::map<std::array<Index, 3>, Index> known;
    const auto point = [&](const std::array<Index, 3>& p) {
      const auto [at, is_new] = known.try_emplace(p, -1);
      if (is_new) at->second = soup.add({lines[0][p[0]], lines[1][p[1]], lines[2][p[2]]});
      return at->second;
    };
    for (Index x = 0; x < count(0); ++x)
      for (Index y = 0; y < count(1); ++y)
        for (Index z = 0; z < count(2); ++z)
          for (std::size_t side = 0; side < 6; ++side) add_side({x, y, z}, side / 2, side % 2 == 1, soup, point);
    return soup;
  }

 private:
  std::size_t place(const std::array<Index, 3>& cell) const {
    return static_cast<std::size_t>((cell[0] * count(1) + cell[1]) * count(2) + cell[2]);
  }
  template <class Point>
  void add_side(const std::array<Index, 3>& cell, std::size_t axis, bool up, Soup& soup, Point point) const {
    auto beyond = cell;
    beyond[axis] += up ? 1 : -1;
    if (!is_solid(cell) || is_solid(beyond)) return;
    std::array<Index, 4> quad;
    for (std::size_t i = 0; i < 4; ++i) {
      auto corner = cell;
      corner[axis] += up;
      corner[(axis + 1) % 3] += i == 1 || i == 2;
      corner[(axis + 2) % 3] += i >= 2;
      quad[i] = point(corner);
    }
    if (!up) std::swap(quad[1], quad[3]);
    soup.add_quad(quad[0], quad[1], quad[2], quad[3]);
  }
};

// A wall of 10 x `thickness` x 8 with cells cut out, or added before its front (y below 0), between lines of x and z.
inline Cells wall(double thickness, double depth, double out, const std::vector<double>& x,
                  const std::vector<double>& z) {
  std::vector<double> y{-out, 0, depth, thickness};
  if (depth >= thickness) y = {-out, 0, thickness};
  const auto with_ends = [](std::vector<double> inner, double end) {
    inner.insert(inner.begin(), 0);
    inner.push_back(end);
    return inner;
  };
  Cells cells({with_ends(x, 10), y, with_ends(z, 8)});
  cells.fill({0, 1, 0}, {cells.count(0), cells.count(1), cells.count(2)}, true);
  return cells;
}

// A block on a grid of broad and narrow gaps, with random boxes added at its sides and cut out of it.
inline Soup block_with_features(Random& random, double narrow, int boxes) {
  std::array<std::vector<double>, 3> lines;
  std::array<Index, 3> low, high;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Index gaps = 4 + below(random, 3);
    lines[axis] = {0};
    for (Index i = 0; i < gaps; ++i)
      lines[axis].push_back(lines[axis].back() + (random() % 3 ? narrow * uniform(random, 0.2, 2.5) : 4));
    low[axis] = below(random, 2), high[axis] = gaps - below(random, 2);
  }
  Cells cells(lines);
  cells.fill(low, high, true);
  for (int i = 0; i < boxes; ++i) {
    std::array<Index, 3> from, to;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      from[axis] = below(random, cells.count(axis));
      to[axis] = std::min(cells.count(axis), from[axis] + 1 + below(random, 2));
    }
    cells.fill(from, to, random() % 5 < 2);
  }
  return cells.surface();
}

}  // namespace shapes
