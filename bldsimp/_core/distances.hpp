// How far points lie from a surface of faces: the measure behind every comparison.
#pragma once

#include <span>
#include <vector>

#include "vec3.hpp"

namespace bldsimp {

// A tree of boxes over the faces of a surface; keeps a copy of what it needs of them. Faces must be in
// range; without faces everything is infinitely far. O(m log m) to make, about O(log m) per query, on all
// cores; the same result whatever their number.
//
// A face may be a needle or have no area at all (it is then its longest side): a distance is wrong by no
// more than a few roundings of the coordinates' differences.
class FaceTree {
 public:
  FaceTree(std::span<const Vec3> points, std::span<const Face> faces);

  std::vector<double> distances(std::span<const Vec3> queries) const;

  // The greatest distance of the queries. Stops once one lies beyond `limit`: then it is some distance
  // greater than that, which may depend on the number of cores.
  double farthest(std::span<const Vec3> queries, double limit) const;

 private:
  struct Box {
    Vec3 low, high;
    double squared_distance(Vec3 p) const;
  };
  // A triangle in a frame of its own: its longest side runs from `origin` along `x`, the corner opposite
  // lies at (foot, height), and both angles at the longest side are acute.
  struct Triangle {
    Vec3 origin, x, y;
    double length, foot, height;
    double squared_distance(Vec3 p) const;
  };
  struct Search {
    Vec3 query;
    double best;
    std::size_t nearest;
  };

  static Triangle framed(Vec3 a, Vec3 b, Vec3 c);
  std::size_t build(std::span<const Vec3> points, std::span<const Face> faces, std::span<const Vec3> middles,
                    std::span<std::size_t> order);
  double distance(Vec3 query, std::size_t& nearest) const;
  void descend(Search& search, std::size_t node, std::size_t begin, std::size_t end) const;

  std::vector<Triangle> triangles_;  // a node is a run of them, halved at its middle
  std::vector<Box> boxes_;
  std::vector<std::size_t> second_;  // the second child; the first follows its parent
};

}  // namespace bldsimp
