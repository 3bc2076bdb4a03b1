// Triangulate points and segments: constrained Delaunay triangulation by morphological recognition.
//
// Points are inserted one by one, in rounds along a Hilbert curve, each located by a walk that crosses
// the edge which sees it on the other side; Lawson flips keep the net Delaunay. Each segment then swaps
// diagonals in its influence domain until it is an edge, and what lies outside the rings is carved
// away. The outside is a fan of ghost triangles around a point at infinity: no bounding triangle
// whose size would have to be guessed, and no hull edge lost.
//
// Cocircular ties go to the diagonal that holds the lexicographically least of the four points:
// a consistent perturbation of the lifted points, so that the triangles depend on the coordinates
// and the segments alone, not on their order.
//
// Source: "Morphological recognition optimization of 3D building simplification by Delaunay
// algorithm", sections on direction search and influence domains; C. L. Lawson, 1977 (flips).
#pragma once

#include <memory>

#include "cdt/hilbert.hpp"
#include "cdt/mesh2d.hpp"
#include "mesh/predicates.hpp"

namespace bldsimp {

enum class Status { done, crossing };

struct TriangulateOptions {
  // Keep only what the rings enclose: triangles that an odd number of segments, at the least,
  // separates from the outside. A piece that segments run along an even number of times does not
  // count (a slit, a shared hole edge), nor does an open end, since the way round it is free.
  // Without any segment nothing is enclosed, and nothing is kept.
  bool carve = true;
  // Let segments cross: they are bent to the crossing point as rounded to doubles.
  bool split_crossings = false;
  // One number per point, or none. When given, Delaunay means that of the points (x, y, lift):
  // with lift = squared length in the plane of a facet, its projection along an axis is
  // triangulated as the facet itself. Where rounding makes the lifted points not quite convex,
  // edges that cannot be flipped stay. A crossing point is lifted to where the segment is, not
  // to the paraboloid, since the lift alone does not tell the distance between two points.
  const double* lift = nullptr;
  // What the standard method goes without: with `recover`, a segment that is no edge becomes one by
  // swapping diagonals; else it is listed in missing(). With `poles`, they tell directions where they can;
  // else determinants tell all.
  bool recover = true;
  bool poles = true;
};

// What the morphological recognition did.
struct Statistics {
  std::int64_t by_poles = 0;        // directions that the poles told
  std::int64_t by_determinant = 0;  // directions that needed a predicate
  std::int64_t located = 0;         // points located by direction search
  std::int64_t walked = 0;          // triangles that these searches entered
  std::int64_t flips = 0;           // diagonals swapped, in insertion and in influence domains

  Statistics& operator+=(const Statistics& other) {
    by_poles += other.by_poles;
    by_determinant += other.by_determinant;
    located += other.located;
    walked += other.walked;
    flips += other.flips;
    return *this;
  }
};

// A reusable workspace: thousands of small facets run through one object without allocating.
// Not shared between threads; each thread has its own.
class Triangulator {
 public:
  // Piece of an input segment between two points next to each other on it.
  struct SegmentPiece {
    Index a, b, segment;
  };
  using Segment = std::array<Index, 2>;
  using Triple = std::array<Index, 3>;

  // Precondition: finite points (fewer than 2^28), segment ends in range. Throws InternalError if
  // an invariant breaks, which is a bug. O(n log n) expected. All points collinear, or fewer than
  // three distinct ones: done, with no triangle and no piece.
  Status run(std::span<const Point2> points, std::span<const Segment> segments, const TriangulateOptions& options = {});

  // After `done`; valid until the next run.
  // The points of the input, then those where segments cross.
  std::span<const Point2> points() const { return points_; }
  // Counter-clockwise rows of points(); of equal points only the lowest index occurs.
  const std::vector<Triple>& triangles() const { return triangles_; }
  // Per triangle and corner the triangle across the edge opposite that corner, or -1.
  const std::vector<Triple>& neighbors() const { return neighbors_; }
  // Per input point the lowest index of an equal one.
  const std::vector<Index>& point_of_input() const { return point_of_input_; }
  // Segments as realized, by segment and along it. Where several segments run along one edge, it
  // occurs once for each; a segment of no length does not occur.
  const std::vector<SegmentPiece>& pieces() const { return pieces_; }
  // Without `recover`: the segments that are no edges, sorted. If there are any, there are no triangles.
  const std::vector<Index>& missing() const { return missing_; }

  // After `crossing`: the two input segments, the lesser first.
  Segment crossing() const { return crossing_; }

  const Statistics& statistics() const { return statistics_; }

  // Gives the arrays away without a copy; the next run makes new ones.
  struct Result {
    std::vector<Point2> points;
    std::vector<Triple> triangles, neighbors;
    std::vector<Index> point_of_input;
    std::vector<SegmentPiece> pieces;
  };
  Result release() {
    return {std::move(points_), std::move(triangles_), std::move(neighbors_), std::move(point_of_input_),
            std::move(pieces_)};
  }

 private:
  // Persistent list of the segments that run along an edge: a node is one use, with the number of
  // uses up to it.
  struct SegmentUse {
    Index segment, next, count;
  };
  struct Pending {
    Index a, b, use;
  };
  struct Box2 {
    Point2 least, most;
  };
  // An edge of an influence domain's rim, with what lies outside.
  struct RimEdge {
    Index origin, target, twin, uses;
  };
  enum class Place { inside, on_edge, at_vertex, outside };
  struct Location {
    Place place;
    Index halfedge;
  };

  // cdt.cpp and legality.hpp: points, steps 1 to 4
  void merge_points(std::span<const Point2> points, const double* lift);
  bool insert_points();
  int direction(Index halfedge, const Point2& target);
  Location locate(const Point2& target, Index start);
  Location locate_by_scan(const Point2& target);
  static Location settle(Index halfedge, int here, int at_after, int at_before);
  template <bool Marked>
  Index insert(Index site, Location location);
  template <bool Marked>
  void legalize_star();
  template <bool Marked>
  bool wants_flip(Index halfedge) const;
  bool lifted_wants_flip(Index p, Index a, Index b, Index q) const;
  bool holds_least(Index p, Index a, Index b, Index q) const;

  // constrain.cpp: step 5
  bool constrain(std::span<const Segment> segments, const TriangulateOptions& options);
  void collect_pending(std::span<const Segment> segments);
  void mark(Index edge, Index use);
  void find_missing();
  Pending realize(Pending segment, Index& crossed);
  Index edge_between(Index a, Index b, bool& fewer_at_b) const;
  Index enter(Index a, Index b, Index& edge) const;
  Index find_influence_domain(Pending segment, Index entered, Index& crossed);
  Index swap_diagonals();
  Index cut_off(Index before, Index after);
  Index fill_anew(Index from, Index reached);
  void note_rim(Indices chain);
  Index fill_side(Indices ring, std::size_t& filled);
  void restore_delaunay();
  void legalize_edges();
  void split_crossing(Pending segment, Index crossed);
  Box2 common_box(Pending s, Pending t) const;
  Point2 crossing_point(Pending s, Pending t) const;
  Index point_nearby(const Point2& point, Location location, Pending s, Pending t);
  double lift_on(Pending segment, const Point2& point) const;

  // carve.cpp: step 6 and the result
  void number_layers();
  void emit(bool carve);
  void emit_pieces(std::span<const Segment> segments);

  HilbertOrder hilbert_;
  Mesh2d mesh_;
  std::vector<Point2> site_;  // distinct points in the order of insertion
  std::vector<double> lift_;  // of sites; empty without lift
  std::vector<Index> input_;  // of sites: row of points_
  std::vector<Index> site_of_input_;
  std::vector<Index> stack_;
  std::vector<SegmentUse> use_;
  std::vector<Pending> pending_;
  std::vector<Index> chain_;  // left of the segment, halfedges inside its influence domain
  std::vector<Index> right_chain_;
  std::vector<Index> domain_;           // triangles of the influence domain
  std::vector<RimEdge> rim_;            // of a large one, sorted
  std::unique_ptr<Triangulator> side_;  // triangulates the sides of large ones
  std::vector<Index> layer_, next_layer_;
  std::int64_t splits_ = 0, most_splits_ = 0;
  double few_units_ = 0.0;  // of rounding, relative to the coordinates

  std::vector<Point2> points_;
  std::vector<Triple> triangles_, neighbors_;
  std::vector<Index> point_of_input_;
  std::vector<SegmentPiece> pieces_;
  std::vector<Index> missing_;
  Segment crossing_{-1, -1};
  bool poles_ = true;
  Statistics statistics_;
};

}  // namespace bldsimp
