#include "details/feature_search.hpp"

namespace bldsimp {
namespace {

// A detail has few facets; what has more is the building.
constexpr std::size_t kMostFacets = 60;
constexpr int kMostGrowth = 12;
// Nor is it surrounded by more than so many facets; noise is.
constexpr std::size_t kMostAround = 24;

std::size_t count_around(const FacetGraph& graph, const std::vector<Loop>& loops) {
  std::vector<Index> around;
  for (const Loop& loop : loops)
    for (const LoopEdge& e : loop)
      if (e.outside >= 0) around.push_back(graph.facet_of(e.outside));
  sort_unique(around);
  return around.size();
}

}  // namespace

std::uint64_t identify(const FacetGraph& graph, const std::vector<Index>& facets, const std::vector<Loop>& loops) {
  std::uint64_t sum = 0;
  const auto add = [&](std::uint64_t seed, Indices ids) {
    std::uint64_t h = seed;
    for (const Index i : ids) h = (h ^ static_cast<std::uint32_t>(i)) * 0x9e3779b97f4a7c15u, h ^= h >> 29;
    sum += h;
  };
  for (const Index k : facets)
    for (const Index f : graph.faces_of(k)) add(1, graph.faces()[f]);
  for (const Loop& loop : loops)
    for (const LoopEdge& e : loop) {
      add(2, std::array{e.from, e.to});
      if (e.outside >= 0) add(3, graph.faces()[e.outside]);
    }
  return sum;
}

FeatureSearch::FeatureSearch(const FacetGraph& graph, LoopCloser& closer, double limit)
    : graph_(graph), closer_(closer), limit_(limit), narrow_(static_cast<std::size_t>(graph.facet_count()), -1) {}

void FeatureSearch::run(std::set<std::uint64_t>& exhausted, const Take& take) {
  for (const Seed& seed : find_seeds()) {
    const std::uint64_t id =
        identify(graph_, seed.facets, graph_.find_loops(seed.facets)) + static_cast<std::uint64_t>(seed.plane >= 0);
    if (!exhausted.contains(id) && !grow(seed, take)) exhausted.insert(id);
  }
}

std::vector<Seed> FeatureSearch::find_seeds() const {
  std::vector<Seed> seeds;
  add_ring_seeds(seeds);
  add_fold_seeds(Fold::concave, seeds);
  add_fold_seeds(Fold::convex, seeds);
  // The smallest first: what is left of it would be in the way of what holds it.
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    Box box;
    for (const Index k : seeds[i].facets) box.add(graph_.shape(k).box);
    order.push_back({length(box.high - box.low), i});
  }
  std::sort(order.begin(), order.end());
  std::vector<Seed> sorted;
  for (const auto& [size, i] : order) sorted.push_back(std::move(seeds[i]));
  return sorted;
}

// What lies across the inner rings of facets.
void FeatureSearch::add_ring_seeds(std::vector<Seed>& seeds) const {
  for (Index k = 0; k < graph_.facet_count(); ++k) {
    if (graph_.neighbors(k).size() < 2 && graph_.faces_of(k).size() < 6) continue;
    const auto loops = graph_.find_loops(std::array{k});
    if (loops.size() < 2) continue;
    for (const Loop& loop : loops) {
      if (graph_.twice_area(loop, graph_.shape(k).normal) >= 0) continue;
      Seed seed{{}, k};
      for (const LoopEdge& e : loop)
        if (e.outside >= 0 && graph_.facet_of(e.outside) != k) seed.facets.push_back(graph_.facet_of(e.outside));
      sort_unique(seed.facets);
      if (!seed.facets.empty()) seeds.push_back(std::move(seed));
    }
  }
}

// Facets that are joined by edges of one kind only.
void FeatureSearch::add_fold_seeds(Fold fold, std::vector<Seed>& seeds) const {
  std::vector<bool> seen(static_cast<std::size_t>(graph_.facet_count()), false);
  for (Index first = 0; first < graph_.facet_count(); ++first) {
    if (seen[first]) continue;
    seen[first] = true;
    std::vector<Index> set{first};
    for (std::size_t i = 0; i < set.size(); ++i)
      for (const auto& [other, at] : graph_.neighbors(set[i])) {
        if (seen[other] || (at != fold && (fold == Fold::concave || at != Fold::mixed))) continue;
        seen[other] = true;
        set.push_back(other);
      }
    if (set.size() > kMostFacets || static_cast<Index>(set.size()) == graph_.facet_count()) continue;
    std::sort(set.begin(), set.end());
    seeds.push_back({std::move(set), -1});
  }
}

bool FeatureSearch::is_narrow(Index facet) {
  if (narrow_[facet] < 0) narrow_[facet] = graph_.width_of(facet) <= 2 * limit_ + 4 * graph_.flat();
  return narrow_[facet] > 0;
}

// What lies across the loops that cannot be closed, as far as it may belong to a detail.
std::vector<Index> FeatureSearch::find_more(const std::vector<Index>& facets, const std::vector<Loop>& loops,
                                            Index plane) {
  std::vector<Index> more;
  for (const Loop& loop : loops) {
    if (closer_.can_close(loop)) continue;
    for (const LoopEdge& e : loop) {
      if (e.outside < 0) continue;
      const Index other = graph_.facet_of(e.outside);
      if (other == plane || std::binary_search(facets.begin(), facets.end(), other)) continue;
      const auto is_parallel = [&] {
        return plane >= 0 && std::abs(dot(graph_.shape(plane).normal, graph_.shape(other).normal)) > parallel_facets &&
               std::abs(graph_.height_over(plane, graph_.shape(other).center)) <= limit_;
      };
      if (is_narrow(other) || is_parallel()) more.push_back(other);
    }
  }
  sort_unique(more);
  return more;
}

// Whether something went.
bool FeatureSearch::grow(const Seed& seed, const Take& take) {
  std::vector<Index> facets = seed.facets;
  for (int step = 0; step < kMostGrowth && facets.size() <= kMostFacets; ++step) {
    const auto loops = graph_.find_loops(facets);
    if (loops.empty() || count_around(graph_, loops) > kMostAround) return false;
    if (take(facets, loops)) return true;
    const auto more = find_more(facets, loops, seed.plane);
    if (more.empty()) return false;
    append(facets, more);
    sort_unique(facets);
  }
  return false;
}

}  // namespace bldsimp
