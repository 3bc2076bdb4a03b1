// Collapse the edges of a surface, and maintain the proof that result and surface are within the tolerance.
#pragma once

#include <optional>
#include <queue>
#include <set>
#include <tuple>

#include "collapse/borders.hpp"
#include "collapse/collapse.hpp"
#include "collapse/containment.hpp"
#include "collapse/held_facets.hpp"
#include "collapse/quadric.hpp"
#include "collapse/walls.hpp"
#include "mesh/certificate.hpp"
#include "mesh/crossings.hpp"
#include "mesh/rounding.hpp"

namespace bldsimp {

// A surface, and what is left of it so far, over the same points.
struct RemainingSurface {
  Points points;  // of the surface
  Faces surface;
  Faces bounded;  // over the same points: what has the borders that are kept
  Indices bounded_label;
  Points positions;  // of what is left
  Faces faces;
  Indices label;
  Flags pinned;  // faces that stay
  Flags shared;  // points that others need as they are, with all that meets there
  Faces beside;  // of others; what is left may not cross them
  double tolerance;
  int decimals;
  bool single;
  Progress* progress;
  Flags fixed = {};   // points that stay where they are; empty for none
  Indices held = {};  // of each face, the plane that it keeps, or -1; empty for none
  std::span<const HeldPlane> planes = {};
  std::span<const double> noticed;  // of each face, the area from which on one in its place is
  const Walls& walls;
};

class Collapser {
 public:
  explicit Collapser(const RemainingSurface& input);

  // Without holders and deviation.
  CollapseResult run();

  // Of each face of the surface, a triangle of the result that holds some of it.
  std::vector<Index> holders() const;

  // Bound of the distance between the surface and a result, both ways.
  double deviation(const CollapseResult& result) const;

 private:
  struct Candidate {
    double cost;
    Index from, to, stamp;
    bool operator<(const Candidate& o) const {  // the least is on top of the queue
      return std::tie(o.cost, o.from, o.to) < std::tie(cost, from, to);
    }
  };
  struct Lower {
    bool operator()(Vec3 p, Vec3 q) const { return lexicographic_less(p, q); }
  };
  struct NewFace {
    Index slot;
    Face face;
    Triangle corners;
  };
  struct NewEdge {
    Index edge;
    Vec3 begin, end;
  };

  Triangle corners(const Face& f) const { return corners_of(f, points_); }
  void find_borders();
  bool is_smooth(Index p) const;
  void fix_points();
  void hold_planes();
  bool keeps_planes(Index a, Vec3 stored) const;
  Vec3 turn_along_planes(Index a, Vec3 way) const;
  void add_quadrics();
  void push_from(Index a);
  void push_next(Index a, const Candidate& last);
  void push_all();
  bool pop_all();
  void move_all();
  std::optional<Quadric> fit(Index a);
  bool move(Index a);
  Index edge_between(Index a, Index b) const;
  void find_neighbors(Index a, std::vector<Index>& near) const;

  void survey(Index a, Index b, Vec3 stored);
  void survey_edges();
  void survey_around();
  std::optional<Refusal> find_refusal();
  bool links() const;
  bool shows_turn(const NewFace& made, double width) const;
  bool leans(const NewFace& made) const;
  bool turns(const NewFace& made) const;
  std::optional<Refusal> shape() const;
  bool folds() const;
  void bound();
  bool backward_at_places();
  bool backward();
  bool backward_edge();
  bool forward();
  void gather_holders();
  bool stays_unheld();
  bool forward_edge();
  std::vector<CrossingTracker::Change> changes() const;
  void commit();
  void apply_collapse();

  RemainingSurface input_;
  double limit_;
  Vec3 middle_{0, 0, 0};
  std::vector<Vec3> origin_, points_;  // about the middle: of the surface, of what is left
  DistinctFaces distinct_;
  std::vector<Face>& faces_;
  std::vector<Labels> labels_;
  std::vector<bool> alive_;
  std::vector<std::vector<Index>> star_, rim_;  // faces and border edges at each point
  std::vector<BorderEdge> edges_;
  std::vector<bool> fixed_;
  std::vector<bool> changed_;             // points near which something has changed since they last tried to move
  std::vector<Index> ways_;               // scratch: neighbors that a point may go to
  std::vector<std::vector<Index>> held_;  // planes that each point keeps
  std::vector<Quadric> quadric_;
  std::vector<Index> stamp_;
  std::priority_queue<Candidate> queue_;
  std::array<Index, edge_kinds> first_edge_{};  // of each kind
  std::optional<FaceTree> tree_;
  std::optional<Certificate> certificate_;          // that what is made lies within the limit of the surface
  std::vector<Index> near_;                         // of each face, one of the surface that was near it
  std::vector<double> far_;                         // how far each face is from the surface at most
  std::array<std::vector<Face>, edge_kinds> rims_;  // borders of the surface of each kind, as faces without area
  std::array<std::optional<FaceTree>, edge_kinds> edge_tree_;
  std::array<std::optional<Certificate>, edge_kinds> edge_certificate_;
  std::optional<ContainmentProof> containment_;
  std::array<std::optional<ContainmentProof>, edge_kinds> edge_containment_;
  CollapseResult result_;
  // Where points of the result are: one that moved to the place of another would be welded to it.
  std::set<Vec3, Lower> places_;
  std::vector<std::vector<ContainmentProof::UnheldCorner>> unheld_;  // that refused to let each point go, the last few
  std::optional<CrossingTracker> crossings_;  // of the result's points: about another origin they are rounded

  // The candidate change: point a moves onto point b, or to the target if b is -1.
  struct {
    Index a, b, edge;                          // border edge a-b; -1 for none
    Vec3 target, stored;                       // the same place, about the middle and as it will be written
    std::vector<Index> dying, moving, around;  // faces; `around` are those that stay as they are, at the ring
    std::vector<NewFace> made;
    std::vector<NewEdge> made_edges;
    std::vector<Index> old, old_edges, ring, apexes;
    std::vector<Holder> holders, edge_holders;
    double far;  // how far what is made is from the surface at most
  } now_;
};

}  // namespace bldsimp
