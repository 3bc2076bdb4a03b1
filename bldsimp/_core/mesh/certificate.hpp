// Certify how far a surface is from another one: a bound of their distance, and whether a change stays near.
#pragma once

#include "mesh/cells.hpp"
#include "mesh/distances.hpp"

namespace bldsimp {

// Certificates of triangles against the faces of one tree, which must outlive it. Keeps its scratch memory: one for
// each thread. What it finds does not depend on what it was asked before.
//
// A triangle is cut into cells, each over one face, along the edges of the faces below it. The corners of a cell prove
// it, so that the number of cells follows the overlaps of the two surfaces and not their size in tolerances.
class Certificate {
 public:
  // Cells shorter than this share of a limit are not cut again.
  static constexpr double finest = FaceTree::finest;

  explicit Certificate(const FaceTree& surface) : surface_(surface) {}

  // How far any point of a triangle is from the surface at most. It is never too small, and exact but for `precision`
  // (or for roundings, where that is less), or for `enough` where it is less than that. `guess` may be a face that is
  // near all of it.
  double bound(const Triangle& triangle, double enough, double precision, Index guess = 0);

  // Whether every point of a triangle is within `limit` of the surface. Never wrongly true; false also where more than
  // a small share of `limit` would have to tell.
  bool holds(const Triangle& triangle, double limit, Index guess = 0);

  // Whether it holds all triangles of a region.
  bool holds(std::span<const Triangle> region, double limit, Index guess = 0);

  // How many cells were measured so far.
  std::int64_t cells() const { return cells_; }

 private:
  // A cell, a face that is near it, and how far any point of it is from that face at most.
  struct MeasuredCell {
    Cell cell;
    Index place;  // of the face in the tree
    int worst;    // corner that is farthest from the face
    double most;
    bool operator<(const MeasuredCell& o) const { return most < o.most; }
  };

  void start(const Triangle& triangle);
  MeasuredCell measure(const Cell& cell, Index place);
  bool improve(MeasuredCell& cell, Index place);
  std::optional<CellParts> cut(const MeasuredCell& cell, Index other, double shortest) const;
  bool many_hold(const MeasuredCell& cell, double limit) const;
  double blur(const Cell& cell) const { return cell.depth() * blur_; }

  const FaceTree& surface_;
  Vec3 normal_{0, 0, 0};  // of the triangle; zero if it has no area
  double blur_ = 0;       // most that a cut moves a corner by
  std::vector<MeasuredCell> left_;
  std::int64_t cells_ = 0;
};

struct SurfaceBound {
  double distance = 0;
  std::int64_t cells = 0;
};

// What to tell of a surface: its bound is exact but for `precision`, or for `known` where it is less than that. A face
// that is farther than `limit`, if anything, is asked once more whether it is within that. `guesses` are near faces of
// the other surface, one for each face, or none at all.
struct BoundGoal {
  double known = 0, precision = 0, limit = std::numeric_limits<double>::infinity();
  Indices guesses = {};
};

// How far any point of a surface is from the other one at most. On all cores; the same result whatever their number.
SurfaceBound bound_distance(Points points, Faces faces, const FaceTree& other, const BoundGoal& goal);

// Whether every point of some faces is within a limit of the other surface; never wrongly true. On all cores.
bool stays_within(Points points, Faces faces, const FaceTree& other, double limit);

}  // namespace bldsimp
