// Search a surface for sets of facets that may be a detail.
#pragma once

#include <functional>
#include <map>
#include <set>

#include "details/feature_candidate.hpp"

namespace bldsimp {

// A number that tells facets with the loops around them, whatever the round. It knows points, not facets.
std::uint64_t identify(const FacetGraph& graph, const std::vector<Index>& facets, const std::vector<Loop>& loops);

// Facets to start from; `plane` is the facet that they interrupt, or -1.
struct Seed {
  std::vector<Index> facets;
  Index plane;
};

// Starts from what lies across the inner rings of facets, and from facets that concave edges alone join, or convex
// ones; takes in what lies across the loops that cannot be closed until all can. Narrow facets are taken in, and those
// parallel to the interrupted facet within `limit`.
class FeatureSearch {
 public:
  // Whether facets (sorted) went as a whole; asked for each set on the way.
  using Take = std::function<bool(const std::vector<Index>& facets, const std::vector<Loop>& loops)>;

  FeatureSearch(const FacetGraph& graph, LoopCloser& closer, double limit);

  // The smallest first. Seeds in `exhausted` are not tried again; those that lead nowhere are added.
  void run(std::set<std::uint64_t>& exhausted, const Take& take);

 private:
  std::vector<Seed> find_seeds() const;
  void add_ring_seeds(std::vector<Seed>& seeds) const;
  void add_fold_seeds(Fold fold, std::vector<Seed>& seeds) const;
  bool grow(const Seed& seed, const Take& take);
  std::vector<Index> find_more(const std::vector<Index>& facets, const std::vector<Loop>& loops, Index plane);
  bool is_narrow(Index facet);

  const FacetGraph& graph_;
  LoopCloser& closer_;
  double limit_;
  std::vector<std::int8_t> narrow_;  // of each facet; -1 not known
};

}  // namespace bldsimp
