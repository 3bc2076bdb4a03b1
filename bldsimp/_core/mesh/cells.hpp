// Cut a triangle into convex cells along the edges of the faces that it lies over.
#pragma once

#include <optional>

#include "mesh/framed_triangle.hpp"

namespace bldsimp {

// A convex polygon, flat but for roundings: part of a triangle.
//
// The distance to a face is greatest at a corner of a cell, so that few distances prove all of it. Each cut is a chord
// between two points of the outline. Whatever suggested the chord, both parts together are the whole: a bad cut makes
// more cells, and never a wrong proof.
class Cell {
 public:
  static constexpr int most_corners = 8;

  // A corner is off its place by less than this share of the greatest coordinate for each cut that led to it.
  static constexpr double rounding = 1e-15;
  // Cells are cut no further than this: what roundings add up to stays small.
  static constexpr int most_depth = 64;

  Cell() = default;
  explicit Cell(const Triangle& triangle) : size_(3) { std::copy(triangle.begin(), triangle.end(), at_.begin()); }
  Cell(Points corners, int depth) : size_(static_cast<int>(corners.size())), depth_(depth) {
    std::copy(corners.begin(), corners.end(), at_.begin());
  }

  int size() const { return size_; }
  int depth() const { return depth_; }
  Vec3 operator[](int i) const { return at_[static_cast<std::size_t>(i)]; }
  Points corners() const { return {at_.data(), static_cast<std::size_t>(size_)}; }
  Vec3 middle() const;
  double diameter() const;

  void add(Vec3 corner) { at_[static_cast<std::size_t>(size_++)] = corner; }

 private:
  std::array<Vec3, most_corners> at_;
  int size_ = 0, depth_ = 0;
};

// A cell in two. Corners of the whole are corners of its parts.
struct CellParts {
  Cell rest, beyond;
};

// What a cell is cut for: its corner `worst` is too far from `own`, the face that the rest may keep. `other` is the
// face nearest to that corner. `normal` is that of the cell.
struct CellCut {
  Vec3 worst, normal;
  const FramedTriangle &own, &other;
};

// A normal of a cell. Without an area that is any direction square to it, best the face's.
Vec3 find_normal(const Cell& cell, const FramedTriangle& face);

// Cuts off a part with the worst corner, along the first of these that leaves something on both sides: an edge of
// `own`, straight above or below; a plane through such an edge square to `own`; an edge of `other`; the line where both
// are equally far; else across the longest way. That last one, too, where both faces are shorter than `shortest`.
// Nothing where the cell is too small or was cut too often.
std::optional<CellParts> cut_cell(const Cell& cell, const CellCut& cut, double shortest);

}  // namespace bldsimp
