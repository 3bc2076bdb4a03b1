#include "planar/thin.hpp"

#include "mesh/errors.hpp"
#include "mesh/predicates.hpp"

namespace bldsimp {
namespace {

// Splits at the farthest point go on so deep before intervals are halved as well. Chains of that many corners
// never get there, and each level costs as much as the chain is long.
constexpr int unbalanced = 32;

bool between(double p, double a, double b) { return std::min(a, b) <= p && p <= std::max(a, b); }

bool exactly_on_segment(Vec3 p, Vec3 a, Vec3 b) {
  const auto collinear = [](double px, double py, double ax, double ay, double bx, double by) {
    return orient2d({ax, ay}, {bx, by}, {px, py}) == 0;
  };
  return between(p.x, a.x, b.x) && between(p.y, a.y, b.y) && between(p.z, a.z, b.z) &&
         collinear(p.x, p.y, a.x, a.y, b.x, b.y) && collinear(p.y, p.z, a.y, a.z, b.y, b.z) &&
         collinear(p.z, p.x, a.z, a.x, b.z, b.x);
}

class Thinner {
 public:
  Thinner(Points points, Indices chain, double limit, std::span<std::uint8_t> kept)
      : points_(points), chain_(chain), limit_(limit), kept_(kept) {}

  void thin() {
    const std::size_t last = chain_.size() - 1;
    kept_[chain_[0]] = kept_[chain_[last]] = 1;
    must_.resize(chain_.size());
    for (std::size_t i = 0; i <= last; ++i) must_[i] = kept_[chain_[i]];
    if (chain_[0] == chain_[last]) keep_three(last);
    for (std::size_t from = 0; from < last;) {
      std::size_t to = from + 1;
      while (!kept_[chain_[to]]) ++to;
      stack_.push_back({from, to, 0});
      from = to;
    }
    while (!stack_.empty()) {
      const auto [from, to, depth] = stack_.back();
      stack_.pop_back();
      if (to - from < 2) continue;
      const auto [at, distance] = farthest(from, to);
      if (!within(from, to, distance)) split(from, to, at, depth + 1);
    }
    drop_again(chain_[0] == chain_[last] ? 3 : 1);
  }

 private:
  struct Interval {
    std::size_t from, to;
    int depth;
  };

  Vec3 point(std::size_t i) const { return points_[chain_[i]]; }

  // The farthest point of a comb is the tip of its next tooth: cut at such points alone, 20,000 teeth took
  // 15 s. So deep intervals are cut in the middle too; what stays there without need is dropped again.
  void split(std::size_t from, std::size_t to, std::size_t at, int depth) {
    const std::size_t other = depth > unbalanced ? middle(from, to) : at;
    const auto [first, second] = std::minmax(at, other);
    kept_[chain_[first]] = kept_[chain_[second]] = 1;
    stack_.push_back({from, first, depth});
    if (first != second) stack_.push_back({first, second, depth});
    stack_.push_back({second, to, depth});
  }

  // Of two middles the one with the lower coordinates, so that the direction of the chain does not matter.
  std::size_t middle(std::size_t from, std::size_t to) const {
    const std::size_t low = from + (to - from) / 2, high = to - (to - from) / 2;
    return chain_[low] <= chain_[high] ? low : high;
  }

  // Ties go to the point with the lower coordinates, so that the direction of the chain does not matter.
  std::pair<std::size_t, double> farthest(std::size_t from, std::size_t to) const {
    std::size_t best = from + 1;
    double distance = -1;
    for (std::size_t i = from + 1; i < to; ++i) {
      const double d = segment_distance(point(i), point(from), point(to));
      if (d > distance || (d == distance && chain_[i] < chain_[best])) {
        distance = d;
        best = i;
      }
    }
    return {best, distance};
  }

  bool within(std::size_t from, std::size_t to, double distance) const {
    if (limit_ > 0) return distance <= limit_;
    for (std::size_t i = from + 1; i < to; ++i)
      if (!exactly_on_segment(point(i), point(from), point(to))) return false;
    return true;
  }

  // The farthest point of an edge that runs along the base is any of its points, as rounding will have it:
  // what proves needless beside the points kept later goes again.
  void drop_again(std::size_t fewest_edges) {
    stay_.clear();
    after_.clear();
    for (std::size_t i = 0; i < chain_.size(); ++i)
      if (kept_[chain_[i]]) after_.push_back(i);
    std::size_t edges = after_.size() - 1;
    std::reverse(after_.begin(), after_.end());
    const auto advance = [&] {
      stay_.push_back(after_.back());
      after_.pop_back();
    };
    // What stays before the point in question, and what is after it, nearest last.
    advance();
    while (after_.size() > 1 && edges > fewest_edges) {
      const std::size_t at = after_.back(), before = stay_.back(), next = after_[after_.size() - 2];
      if (must_[at] || !within(before, next, farthest(before, next).second)) {
        advance();
        continue;
      }
      kept_[chain_[at]] = 0;
      after_.pop_back();
      --edges;
      if (stay_.size() > 1) {
        after_.push_back(stay_.back());
        stay_.pop_back();
      }
    }
  }

  void keep_three(std::size_t last) {
    std::size_t kept = 0;
    for (std::size_t i = 1; i < last; ++i) kept += kept_[chain_[i]];
    if (kept == 0) {
      kept_[chain_[farthest(0, last).first]] = 1;
      ++kept;
    }
    if (kept > 1) return;
    std::size_t middle = 1;
    while (!kept_[chain_[middle]]) ++middle;
    std::size_t best = last;
    double distance = -1;
    for (const auto& [from, to] : {std::pair{std::size_t{0}, middle}, std::pair{middle, last}}) {
      if (to - from < 2) continue;
      const auto [at, d] = farthest(from, to);
      if (d > distance || (d == distance && chain_[at] < chain_[best])) {
        best = at;
        distance = d;
      }
    }
    kept_[chain_[best]] = 1;
  }

  Points points_;
  Indices chain_;
  double limit_;
  std::span<std::uint8_t> kept_;
  std::vector<std::uint8_t> must_;  // per position: kept from the start
  std::vector<Interval> stack_;
  std::vector<std::size_t> stay_, after_;
};

Indices chain_points(const Outlines& outlines, std::size_t c) {
  return {outlines.chain_points.data() + outlines.chain_start[c],
          outlines.chain_points.data() + outlines.chain_start[c + 1]};
}

// The uses of pieces that share both ends, seen from the lower to the upper end.
std::vector<FacetUse> all_uses(std::span<const Piece> pieces, Indices same, const Outlines& outlines) {
  std::vector<FacetUse> uses;
  for (const Index i : same) {
    const Piece& piece = pieces[i];
    for (Index u = outlines.use_start[piece.chain]; u < outlines.use_start[piece.chain + 1]; ++u)
      uses.push_back({outlines.uses[u].facet, outlines.uses[u].forward == (piece.from < piece.to)});
  }
  std::sort(uses.begin(), uses.end());
  return uses;
}

// What is left when opposite uses by one facet cancel.
std::vector<FacetUse> cancel_opposites(std::span<const FacetUse> uses) {
  std::vector<FacetUse> remaining;
  for (const FacetUse& use : uses) {
    if (!remaining.empty() && remaining.back().facet == use.facet && remaining.back().forward != use.forward)
      remaining.pop_back();
    else
      remaining.push_back(use);
  }
  return remaining;
}

}  // namespace

std::vector<std::uint8_t> thin_chains(Points points, const Outlines& outlines, std::span<const double> limit,
                                      Flags keep) {
  std::vector<std::uint8_t> kept(keep.begin(), keep.end());
  for (std::size_t c = 0; c + 1 < outlines.chain_start.size(); ++c)
    Thinner(points, chain_points(outlines, c), limit[c], kept).thin();
  return kept;
}

std::vector<Piece> lay_pieces(Points points, const Outlines& outlines, Flags kept) {
  std::vector<Piece> pieces;
  for (std::size_t c = 0; c + 1 < outlines.chain_start.size(); ++c) {
    const auto chain = chain_points(outlines, c);
    if (!kept[chain.front()] || !kept[chain.back()]) throw InternalError("lay_pieces", "an end of a chain is not kept");
    for (std::size_t from = 0; from + 1 < chain.size();) {
      std::size_t to = from + 1;
      while (!kept[chain[to]]) ++to;
      Piece piece{chain[from], chain[to], static_cast<Index>(c), -1, 0};
      for (std::size_t i = from + 1; i < to; ++i) {
        const double d = segment_distance(points[chain[i]], points[piece.from], points[piece.to]);
        if (piece.farthest < 0 || d > piece.deviation || (d == piece.deviation && chain[i] < piece.farthest)) {
          piece.farthest = chain[i];
          piece.deviation = d;
        }
      }
      pieces.push_back(piece);
      from = to;
    }
  }
  return pieces;
}

PieceEdges merge_pieces(const std::vector<Piece>& pieces, const Outlines& outlines) {
  const auto ends = [&](Index i) { return std::minmax(pieces[i].from, pieces[i].to); };
  std::vector<Index> order = list_indices(pieces.size());
  std::sort(order.begin(), order.end(), [&](Index i, Index j) { return ends(i) < ends(j); });
  PieceEdges result;
  const auto same_ends = [&](Index i, Index j) { return ends(i) == ends(j); };
  for_runs(order, same_ends, [&](Indices same) {
    std::vector<FacetUse> uses = all_uses(pieces, same, outlines);
    if (same.size() > 1) {
      const std::vector<FacetUse> remaining = cancel_opposites(uses);
      const bool joined = remaining.size() == 2 && remaining[0].forward != remaining[1].forward;
      const bool closed_slit = uses.size() == 2 && remaining.empty();
      if (joined || closed_slit) {
        ++result.healed;
        append(result.healed_pieces, same);
      } else {
        for (const Index i : same)
          if (pieces[i].farthest >= 0) result.clashing.push_back(pieces[i].farthest);
      }
      if (joined) uses = remaining;
    }
    result.edges.push_back({ends(same[0]).first, ends(same[0]).second});
    append(result.uses, uses);
    result.use_start.push_back(static_cast<Index>(result.uses.size()));
  });
  sort_unique(result.clashing);
  return result;
}

}  // namespace bldsimp
