// Close the loops around facets that go, with caps in the planes of the facets around them.
#pragma once

#include <optional>

#include "cdt/cdt.hpp"
#include "details/facet_graph.hpp"

namespace bldsimp {

// Why the loops around some facets cannot be closed.
enum class Unclosed : std::uint8_t {
  open,     // a loop runs partly along open edges
  plane,    // no plane of the facets around continues over a loop
  label,    // the facets around have several labels
  outline,  // the outline of a cap touches or crosses itself, or winds the wrong way
  edge,     // a cap would share an edge with what stays
  count
};

// Faces that close the loops, with the face that each continues; and points that have moved for it.
struct Caps {
  std::vector<Face> faces;
  std::vector<Index> parent;
  std::vector<std::pair<Index, Vec3>> moved;
};

class LoopCloser {
 public:
  explicit LoopCloser(const FacetGraph& graph) : graph_(graph) {}

  // Closes the loops around facets (sorted). Loops that cannot be closed slide into the plane of another one, by at
  // most `reach`; at 0 none slides.
  std::optional<Caps> close(const std::vector<Loop>& loops, Indices facets, double reach);
  // Closes a loop of open edges, in a plane or without one. It adds no point.
  std::optional<Caps> close_open(const Loop& loop);
  Unclosed why() const { return why_; }

  // Whether a loop alone can be closed in the planes around it.
  bool can_close(const Loop& loop);

 private:
  // Edges that follow one another along facets of one plane; points from the one before them to the last.
  struct Run {
    Index facet;
    std::vector<Index> points;
  };
  // What a cap covers: rings in the plane of a facet.
  struct Outline {
    Index facet;
    std::vector<std::vector<Index>> rings;
  };

  Vec3 at(Index point) const;
  bool on_plane(Index facet, Index point) const {
    return std::abs(graph_.height_over(facet, at(point))) <= 4 * graph_.flat();
  }
  std::vector<Run> find_runs(const Loop& loop);
  bool reduce(const Loop& loop);
  bool take_apart(const Loop& loop);
  bool cut_shortest(std::vector<Run>& runs);
  bool close_two(std::vector<Run>& runs);
  bool close_three(std::vector<Run>& runs);
  void add_outline(const Run& run, bool is_ring);
  bool slide(const Loop& loop, Indices facets, Index plane, double reach);
  std::optional<Vec3> slide_point(Index point, Indices facets, Index plane, double reach) const;
  bool triangulate(Outline& outline, Caps& caps);
  bool fits(const std::vector<Loop>& loops, Indices facets, const Caps& caps);
  bool refuse(Unclosed why) {
    why_ = why;
    return false;
  }

  bool refuse_plane() { return refuse(labels_part_ ? Unclosed::label : Unclosed::plane); }

  const FacetGraph& graph_;
  Triangulator triangulator_;
  Unclosed why_ = Unclosed::plane;
  bool labels_part_ = false;  // whether labels alone part facets around the loop
  Index free_point_ = -1;
  std::vector<Outline> flat_, bent_;  // of loops in one plane, and of others
  std::vector<std::pair<Index, Vec3>> moved_;
};

}  // namespace bldsimp
