// Measure how far points lie from a surface of faces.
#pragma once

#include "mesh/box_tree.hpp"
#include "mesh/framed_triangle.hpp"
#include "mesh/panels.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {

// A tree of boxes over the faces of a surface; keeps a copy of what it needs of them. Faces must be in
// range; without faces everything is infinitely far. O(m log m) to make, about O(log m) per query, on all
// cores; the same result whatever their number.
//
// A face may be a needle or have no area at all (it is then its longest side): a distance is wrong by no
// more than a few roundings of the coordinates' differences.
class FaceTree {
 public:
  // Parts of a triangle shorter than this share of a limit are not halved again.
  static constexpr double finest = 1.0 / 64;

  FaceTree(Points points, Faces faces);

  // One that knows panels that are flat but for a limit, for certificates of large triangles at that limit.
  FaceTree(Points points, Faces faces, double limit);

  // The faces, in an order in which near ones mostly are beside each other.
  const std::vector<Index>& order() const { return tree_.order(); }

  std::vector<double> distances(Points queries) const;

  // The greatest distance of the queries. Stops once one lies beyond `limit`: then it is some distance
  // greater than that, which may depend on the number of cores.
  double farthest(Points queries, double limit) const;

  // Of the face that comes nearest, whose index is `nearest`; what it holds before is a first guess.
  double distance(Vec3 query, Index& nearest) const;

  double to_face(Vec3 query, Index face) const;

  // The same by places in the tree, for who asks often.
  Index place_of(Index face) const { return place_[face]; }
  const FramedTriangle& triangle(Index place) const { return triangles_[place]; }
  // One that is within `enough` will do as well.
  double nearest(Vec3 query, Index& place, double enough = 0) const;

  // Whether a point is within `limit` of the faces; `nearest` is one that it is near then, and a guess before.
  bool within(Vec3 query, double limit, Index& nearest) const;

  // Calls face(place) for all faces within a distance of a point, until that is false.
  template <class Visit>
  bool visit_near(Vec3 p, double d, Visit each) const {
    const Vec3 around{d, d, d};
    return tree_.visit(Box{p - around, p + around}, [&](Index i) { return !triangles_[i].within(p, d) || each(i); });
  }

  // Whether a panel near `middle` tells that all between some corners that are `size` apart is within the limit.
  bool panel_holds(Points corners, Vec3 middle, double size, double limit) const;

  // Whether one face is within the limit of a whole piece, or some face of its middle at least. `place` is where in
  // the tree it is, and a guess before. A face with this normal is held only by faces that are roughly parallel to it
  // and lie under it rather than beside it; if that is zero, by any.
  enum class Coverage { nowhere, middle, whole };
  Coverage find_coverage(const Triangle& piece, double longest, double limit, Vec3 normal, Index& place) const;

 private:
  bool panel_holds(Index node, Points corners, Vec3 middle, double size, double limit) const;

  BoxTree tree_;
  Panels panels_;
  std::vector<FramedTriangle> triangles_;  // in the order of the tree
  std::vector<Index> place_;               // of each face among them
};

}  // namespace bldsimp
