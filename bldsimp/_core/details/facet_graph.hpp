// See a surface as facets, with the loops of edges around some of them and what lies across.
#pragma once

#include "mesh/box_tree.hpp"
#include "planar/facets.hpp"

namespace bldsimp {

// How two facets meet: the angle between them, seen from outside, is over or under half a turn; or neither all along.
enum class Fold : std::int8_t { concave = -1, mixed = 0, convex = 1 };

struct FacetNeighbor {
  Index facet;
  Fold fold;
};

// An edge of a loop, in the direction in which the faces that go run along it. `outside` is the face across; -1 where
// there is none.
struct LoopEdge {
  Index from, to, outside;
};
using Loop = std::vector<LoopEdge>;

// A facet is large where its area divided by its length is more than this many tolerances.
inline constexpr double large_facet = 2;
// Cosine of the angle within which two facets are parallel.
inline constexpr double parallel_facets = 0.99;

// What a facet is as a whole.
struct FacetShape {
  Vec3 normal{0, 0, 0};
  double offset = 0;  // normal . point of its plane
  double area = 0;
  Box box;
  Vec3 center{0, 0, 0};
  double radius = 0;  // of a ball about the center that holds it
  Index label = 0;
};

class FacetGraph {
 public:
  // Facets are flat within `flat` to either side. O(n log n).
  FacetGraph(Points points, Faces faces, Indices label, double flat);

  Points points() const { return points_; }
  Faces faces() const { return faces_; }
  double flat() const { return flat_; }
  Index facet_count() const { return static_cast<Index>(shapes_.size()); }
  Index facet_of(Index face) const { return facets_.facet_of_face[face]; }
  Indices faces_of(Index facet) const { return members_[facet]; }
  Indices faces_at(Index point) const { return star_[point]; }
  const FacetShape& shape(Index facet) const { return shapes_[facet]; }
  std::span<const FacetNeighbor> neighbors(Index facet) const {
    return {neighbors_.data() + neighbor_start_[facet], neighbors_.data() + neighbor_start_[facet + 1]};
  }

  double height_over(Index facet, Vec3 p) const { return dot(shapes_[facet].normal, p) - shapes_[facet].offset; }
  // Whether two facets lie in one plane, facing the same way.
  bool share_plane(Index f, Index g) const;
  // The same for facets with one label.
  bool continues(Index f, Index g) const { return shapes_[f].label == shapes_[g].label && share_plane(f, g); }
  // Whether the area of a facet divided by its length is over a width.
  bool is_wider(Index facet, double width) const { return shapes_[facet].area > width * 2 * shapes_[facet].radius; }
  // Extent of a facet across its longest way.
  double width_of(Index facet) const;

  // The loops around some facets, which are sorted. O(their faces).
  std::vector<Loop> find_loops(Indices facets) const;
  // The loops of open edges, as a face that closed them would run.
  std::vector<Loop> find_open_loops() const;
  // Twice the area that a loop encloses, seen along a normal.
  double twice_area(const Loop& loop, Vec3 normal) const;

 private:
  void measure_shapes();
  void find_neighbors();
  Fold fold_at(Index halfedge, Index twin) const;

  std::vector<Vec3> points_;
  std::vector<Face> faces_;
  double flat_;
  Halfedges halfedges_;
  Facets facets_;
  Groups members_, star_;
  std::vector<FacetShape> shapes_;
  std::vector<Index> neighbor_start_;
  std::vector<FacetNeighbor> neighbors_;
};

}  // namespace bldsimp
