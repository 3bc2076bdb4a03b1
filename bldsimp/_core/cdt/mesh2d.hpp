// Hold a mesh of triangles in the plane: halfedges, flips and stars. Topology only; it knows no coordinates.
//
// Halfedge 4t + i is edge i of triangle t, from vertex i to vertex i + 1 (modulo 3), interior on the
// left. The hull is closed by ghost triangles that share the vertex `infinite`, so that every
// halfedge has a twin.
#pragma once

#include "mesh/predicates.hpp"

namespace bldsimp {

inline constexpr Index infinite = -1;

class Mesh2d {
 public:
  static Index next(Index h) { return (h & 3) == 2 ? h - 2 : h + 1; }
  static Index prev(Index h) { return (h & 3) == 0 ? h + 2 : h - 1; }
  static Index triangle(Index h) { return h >> 2; }

  Index twin(Index h) const { return cell_[h >> 2].twin[h & 3]; }
  Index origin(Index h) const { return cell_[h >> 2].vertex[h & 3]; }
  Index target(Index h) const { return origin(next(h)); }
  Index apex(Index h) const { return origin(prev(h)); }
  Index size() const { return static_cast<Index>(cell_.size()); }
  bool ghost(Index t) const {
    const Index* const v = cell_[t].vertex;
    return v[0] < 0 || v[1] < 0 || v[2] < 0;
  }
  // A free number per triangle.
  Index& label(Index t) { return cell_[t].vertex[3]; }
  Index label(Index t) const { return cell_[t].vertex[3]; }

  // Head of the list of segments on the edge, -1 for none. Valid after `begin_marks`.
  Index mark(Index h) const { return mark_[h]; }
  void set_mark(Index h, Index uses) { mark_[h] = mark_[twin(h)] = uses; }
  // A halfedge that leaves the vertex. Valid after `begin_marks`.
  Index leaving(Index vertex) const { return leaving_[vertex]; }

  void clear(std::size_t expected_triangles) {
    cell_.clear();
    cell_.reserve(expected_triangles);
  }

  // From here on flips and stars keep marks and `leaving`.
  void begin_marks(std::size_t vertices) {
    mark_.assign(cell_.size() * 4, -1);
    leaving_.assign(vertices, -1);
    for (Index t = 0; t < size(); ++t)
      for (Index i = 0; i < 3; ++i)
        if (cell_[t].vertex[i] >= 0) leaving_[cell_[t].vertex[i]] = 4 * t + i;
  }

  // The first triangle, counter-clockwise, and its three ghosts; the net must be empty.
  void found(Index a, Index b, Index c) {
    cell_.resize(4);
    cell_[0] = {{a, b, c, 0}, {4, 8, 12, -1}};
    cell_[1] = {{b, a, infinite, 0}, {0, 14, 9, -1}};
    cell_[2] = {{c, b, infinite, 0}, {1, 6, 13, -1}};
    cell_[3] = {{a, c, infinite, 0}, {2, 10, 5, -1}};
  }

  // Gives a triangle other vertices; all its edges must then be joined anew.
  void replace(Index t, const std::array<Index, 3>& vertices) {
    for (Index i = 0; i < 3; ++i) {
      set_origin(4 * t + i, vertices[i]);
      leaving_[vertices[i]] = 4 * t + i;
    }
  }
  void join(Index h, Index g, Index uses) {
    link(h, g);
    set_mark(h, uses);
  }

  // Swaps the diagonal of the two triangles at h. With b = twin(h) the new diagonal is prev(h),
  // prev(b); the four edges around are h, next(h), b, next(b), where next(h) and next(b) stay what
  // they were, h becomes the former prev(b) and b the former prev(h).
  template <bool Marked>
  void flip(Index h) {
    const Index b = twin(h);
    const Index before_h = prev(h), before_b = prev(b);
    const Index left = origin(before_h), right = origin(before_b);
    if constexpr (Marked) {
      if (origin(h) >= 0) leaving_[origin(h)] = next(b);
      if (origin(b) >= 0) leaving_[origin(b)] = next(h);
      mark_[h] = mark_[before_b];
      mark_[b] = mark_[before_h];
      mark_[before_h] = mark_[before_b] = -1;
    }
    link(h, twin(before_b));
    link(b, twin(before_h));
    link(before_h, before_b);
    set_origin(h, right);
    set_origin(b, left);
    if constexpr (Marked) {
      if (left >= 0) leaving_[left] = before_h;
      if (right >= 0) leaving_[right] = before_b;
    }
  }

  // Puts a vertex into triangle t, or with `on_edge` on halfedge h of it: three or four triangles
  // around it. Returns their number; halfedges opposite the vertex are in `rim`.
  template <bool Marked>
  int star(Index vertex, Index h, bool on_edge, std::array<Index, 4>& rim) {
    struct StarSide {
      Index origin, twin, mark, spoke_mark, home;
    };
    std::array<StarSide, 4> side{};
    const int sides = on_edge ? 4 : 3;
    const auto read = [&](int i, Index from, Index home) {
      side[i] = {origin(from), twin(from), Marked ? mark_[from] : -1, -1, home};
    };
    const auto fresh = [&] {
      cell_.push_back({});
      if constexpr (Marked) mark_.resize(cell_.size() * 4, -1);
      return size() - 1;
    };
    const Index t = triangle(h);
    if (on_edge) {
      const Index g = twin(h), u = triangle(g);
      read(0, next(h), t);
      read(1, prev(h), -1);
      read(2, next(g), u);
      read(3, prev(g), -1);
      if constexpr (Marked) side[0].spoke_mark = side[2].spoke_mark = mark_[h];
    } else {
      read(0, h, t);
      read(1, next(h), -1);
      read(2, prev(h), -1);
    }
    for (int i = 0; i < sides; ++i)
      if (side[i].home < 0) side[i].home = fresh();
    for (int i = 0; i < sides; ++i) {
      const StarSide& now = side[i];
      const StarSide& after = side[(i + 1) % sides];
      const StarSide& before = side[(i + sides - 1) % sides];
      const Index base = 4 * now.home;
      cell_[now.home] = {{now.origin, after.origin, vertex, 0}, {-1, 4 * after.home + 2, 4 * before.home + 1, -1}};
      link(base, now.twin);
      if constexpr (Marked) {
        mark_[base] = now.mark;
        mark_[base + 1] = after.spoke_mark;
        mark_[base + 2] = now.spoke_mark;
        if (now.origin >= 0) leaving_[now.origin] = base;
      }
      rim[i] = base;
    }
    if constexpr (Marked) {
      const auto needed = static_cast<std::size_t>(vertex) + 1;
      if (leaving_.size() < needed) leaving_.resize(needed);
      leaving_[vertex] = 4 * side[0].home + 2;
    }
    return sides;
  }

 private:
  struct alignas(32) Cell {
    Index vertex[4];  // the fourth is the label
    Index twin[4];    // the fourth is not used
  };

  void link(Index h, Index g) {
    cell_[h >> 2].twin[h & 3] = g;
    cell_[g >> 2].twin[g & 3] = h;
  }
  void set_origin(Index h, Index vertex) { cell_[h >> 2].vertex[h & 3] = vertex; }

  std::vector<Cell> cell_;
  std::vector<Index> mark_, leaving_;
};

}  // namespace bldsimp
