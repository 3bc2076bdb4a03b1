#include "collapse/collapser.hpp"

#include <iterator>
#include <limits>

#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

// Weight of an edge's length among costs: of equal ones the shortest goes first.
constexpr double kLength = 1e-6;
// Precision of the final bound, as a share of the tolerance, of which it takes as much away.
constexpr double kPrecision = 1e-4;
// A point moves if that brings it nearer to its planes by this share of the tolerance.
constexpr double kWorthMoving = 0.1;
// Planes count as parallel where one tells less than this share across the other; the second where the first was
// too bold.
constexpr double kParallel[] = {1e-3, 0.1};
// What moves with a point by less than this share of its own way has no say in where it goes.
constexpr double kLeastShare = 0.1;
// What is nearer than this share of the tolerance fits.
constexpr double kFitting = 0.02;
// A point is in a plane that it keeps up to this share of the tolerance.
constexpr double kHeld = 0.06;
// Planes that part by less than this sine count as one.
constexpr double kLeastTurn = 0.1;
constexpr int kMostRounds = 8;
Index third(const Face& f, Index p, Index q) {
  return *std::find_if(f.begin(), f.end(), [&](Index r) { return r != p && r != q; });
}

}  // namespace

Collapser::Collapser(const RemainingSurface& input)
    : input_(input), limit_((1 - kPrecision) * input.tolerance), distinct_(merge_copies(input.faces)),
      faces_(distinct_.faces), labels_(pair_labels(distinct_, input.label)), near_(faces_.size(), 0),
      far_(faces_.size(), std::ranges::equal(input.faces, input.surface) ? 0.0 : limit_) {
  const std::size_t n = input.points.size();
  if (n) middle_ = input.points[n / 2];
  for (const Vec3& p : input.points) origin_.push_back(p - middle_);
  for (const Vec3& p : input.positions) points_.push_back(p - middle_);
  result_.points.assign(input.positions.begin(), input.positions.end());
  alive_.assign(faces_.size(), true);
  star_.resize(n);
  rim_.resize(n);
  fixed_.assign(n, false);
  changed_.assign(n, true);
  unheld_.resize(n);
  stamp_.assign(n, 0);
  for (std::size_t f = 0; f < faces_.size(); ++f)
    for (const Index p : faces_[f]) star_[p].push_back(static_cast<Index>(f));
  tree_.emplace(origin_, input.surface, limit_);
  certificate_.emplace(*tree_);
  containment_.emplace(origin_, input.surface, tree_->order(), points_, faces_, limit_);
  crossings_.emplace(result_.points, faces_, input.beside);
  for (const auto& faces : {Faces(faces_), input.beside})
    for (const Face& f : faces)
      for (const Index p : f) places_.insert(result_.points[p]);
  find_borders();
  fix_points();
  hold_planes();
  add_quadrics();
}

void Collapser::find_borders() {
  edges_ = find_border_edges(faces_, points_.size(), labels_);
  std::stable_sort(edges_.begin(), edges_.end(),
                   [](const BorderEdge& e, const BorderEdge& f) { return e.kind < f.kind; });
  for (std::size_t e = 0; e < edges_.size(); ++e)
    for (const Index p : edges_[e].ends) rim_[p].push_back(static_cast<Index>(e));
  const DistinctFaces whole = merge_copies(input_.bounded);
  const auto own = find_border_edges(whole.faces, points_.size(), pair_labels(whole, input_.bounded_label));
  for (int kind = 0; kind < edge_kinds; ++kind) {
    const auto now = flatten_edges(edges_, kind);
    auto before = flatten_edges(own, kind);
    // Those between shared points stay, and may be borders here only.
    std::erase_if(before, [&](const Face& edge) { return input_.shared[edge[0]] && input_.shared[edge[1]]; });
    if (kind + 1 < edge_kinds) first_edge_[kind + 1] = first_edge_[kind] + static_cast<Index>(now.size());
    rims_[kind] = before;
    edge_tree_[kind].emplace(origin_, before);
    edge_certificate_[kind].emplace(*edge_tree_[kind]);
    edge_containment_[kind].emplace(origin_, before, edge_tree_[kind]->order(), points_, now, limit_);
  }
}

// Whether a point lies inside of one sheet or of one chain of borders: the faces around it, each joined to the next
// where no border parts them, are one ring, or all of them lead from one border edge to the other.
bool Collapser::is_smooth(Index p) const {
  const auto& rim = rim_[p];
  if (!rim.empty() && (rim.size() != 2 || edges_[rim[0]].labels != edges_[rim[1]].labels)) return false;
  std::vector<IndexPair> spokes;  // {other end, face}
  for (const Index f : star_[p])
    for (const Index q : faces_[f])
      if (q != p) spokes.push_back({q, f});
  std::sort(spokes.begin(), spokes.end());
  const auto other_end = [&](Index e) { return edges_[e].ends[edges_[e].ends[0] == p]; };
  const Index first = rim.empty() ? spokes[0][0] : other_end(rim[0]), last = rim.empty() ? first : other_end(rim[1]);
  std::size_t seen = 0;
  for (const auto& [start, leaving] : spokes) {
    if (start != first || (rim.empty() && seen > 0)) continue;
    Index q = start, f = leaving;
    for (;;) {
      ++seen;
      q = third(faces_[f], p, q);
      if (q == last) break;
      if (edge_between(p, q) >= 0) return false;
      const auto at = std::lower_bound(spokes.begin(), spokes.end(), IndexPair{q, 0});
      f = (*at)[1] == f ? (*(at + 1))[1] : (*at)[1];
    }
  }
  return seen == star_[p].size();
}

// Points stay where chains of borders meet or end, where sheets touch, where others need them, and where nothing is
// proven.
void Collapser::fix_points() {
  for (std::size_t p = 0; p < points_.size(); ++p)
    fixed_[p] = input_.shared[p] || (!input_.fixed.empty() && input_.fixed[p]) ||
                (!star_[p].empty() && !is_smooth(static_cast<Index>(p)));
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const bool stays =
        input_.pinned[distinct_.index[f]] || (distinct_.copy[f] >= 0 && input_.pinned[distinct_.copy[f]]);
    if (stays)
      for (const Index p : faces_[f]) fixed_[p] = true;
  }
  for (const Index f : containment_->unproven())
    for (const Index p : faces_[f]) fixed_[p] = true;
}

void Collapser::hold_planes() {
  held_.resize(points_.size());
  if (input_.held.empty()) return;
  for (std::size_t f = 0; f < faces_.size(); ++f)
    for (const Index given : {distinct_.index[f], distinct_.copy[f]})
      if (given >= 0 && input_.held[given] >= 0)
        for (const Index p : faces_[f]) held_[p].push_back(input_.held[given]);
  for (auto& planes : held_) sort_unique(planes);
}

// Whether a point that comes to a place stays in the planes that it keeps.
bool Collapser::keeps_planes(Index a, Vec3 stored) const {
  return std::all_of(held_[a].begin(), held_[a].end(), [&](Index plane) {
    const auto& [normal, offset] = input_.planes[plane];
    return std::abs(dot(normal, stored) - offset) <= kHeld * limit_;
  });
}

// A way without what leads out of the planes that a point keeps.
Vec3 Collapser::turn_along_planes(Index a, Vec3 way) const {
  std::vector<Vec3> across;
  for (const Index plane : held_[a]) {
    Vec3 n = input_.planes[plane].normal;
    for (const Vec3& m : across) n = n - dot(n, m) * m;
    const double size = length(n);
    if (size < kLeastTurn) continue;
    if (across.size() == 2) return {0, 0, 0};
    across.push_back((1 / size) * n);
    way = way - dot(way, across.back()) * across.back();
  }
  return way;
}

void Collapser::add_quadrics() {
  quadric_.resize(points_.size());
  const auto add = [&](Index p, Vec3 n, Vec3 through, double weight) { quadric_[p].add(n, -dot(n, through), weight); };
  for (const Face& f : faces_) {
    const Vec3 n = area_vector(corners(f));
    const double twice = length(n);
    if (twice == 0) continue;
    for (const Index p : f) add(p, (1 / twice) * n, points_[f[0]], twice / 6);
  }
  for (const BorderEdge& e : edges_) {
    const auto [a, b] = e.ends;
    const Vec3 along = points_[b] - points_[a];
    for (const Index f : star_[a]) {
      if (!has_corner(faces_[f], b)) continue;
      const Vec3 n = cross(along, area_vector(corners(faces_[f])));
      const double size = length(n);
      if (size == 0) continue;
      for (const Index p : e.ends) add(p, (1 / size) * n, points_[a], dot(along, along) / 2);
    }
  }
}

Index Collapser::edge_between(Index a, Index b) const {
  for (const Index e : rim_[a])
    if (edges_[e].ends[0] == b || edges_[e].ends[1] == b) return e;
  return -1;
}

void Collapser::find_neighbors(Index a, std::vector<Index>& near) const {
  near.clear();
  for (const Index f : star_[a])
    for (const Index p : faces_[f])
      if (p != a) near.push_back(p);
  sort_unique(near);
}

void Collapser::push_from(Index a) {
  ++stamp_[a];
  push_next(a, {-1, a, -1, 0});
}

// The best way for a point to go after one that was refused: others can wait until that is refused too.
void Collapser::push_next(Index a, const Candidate& last) {
  if (fixed_[a]) return;
  std::optional<Candidate> best;
  find_neighbors(a, ways_);
  for (const Index b : ways_) {
    if (input_.shared[b] || (!rim_[a].empty() && edge_between(a, b) < 0) || !keeps_planes(a, result_.points[b]))
      continue;
    Quadric sum = quadric_[a];
    sum.add(quadric_[b]);
    const Vec3 way = points_[b] - points_[a];
    const double size = dot(way, way);
    const Candidate next{std::max(sum.at(points_[b]), 0.0) + kLength * size * size, a, b, stamp_[a]};
    if (next < last && (!best || *best < next)) best = next;
  }
  if (best) queue_.push(*best);
}

void Collapser::push_all() {
  for (std::size_t p = 0; p < points_.size(); ++p)
    if (!star_[p].empty()) push_from(static_cast<Index>(p));
}

// Makes the proof that was found the standing one.
void Collapser::commit() {
  containment_->commit(now_.old, now_.holders);
  crossings_->commit(now_.old, changes());
  for (const NewFace& made : now_.made) far_[made.slot] = now_.far;
  for (const Index p : now_.ring) changed_[p] = true;
  if (now_.old_edges.empty()) return;
  const int kind = edges_[now_.old_edges[0]].kind;
  std::vector<Index> old(now_.old_edges);
  for (Index& e : old) e -= first_edge_[kind];
  edge_containment_[kind]->commit(old, now_.edge_holders);
}

void Collapser::apply_collapse() {
  const auto& now = now_;
  const Index a = now.a, b = now.b;
  if (now.edge >= 0) {
    const Index rest = now.made_edges[0].edge;
    std::erase(rim_[b], now.edge);
    rim_[b].push_back(rest);
    for (Index& p : edges_[rest].ends)
      if (p == a) p = b;
    rim_[a].clear();
  }
  for (const Index f : now.dying) {
    alive_[f] = false;
    for (const Index p : faces_[f])
      if (p != a) std::erase(star_[p], f);
  }
  for (const NewFace& made : now.made) {
    faces_[made.slot] = made.face;
    star_[b].push_back(made.slot);
  }
  star_[a].clear();
  places_.erase(result_.points[a]);
  ++stamp_[a];
  quadric_[b].add(quadric_[a]);
  append(held_[b], held_[a]);
  sort_unique(held_[b]);
  for (const Index p : now.ring) push_from(p);
}

bool Collapser::pop_all() {
  const Index before = result_.accepted;
  while (!queue_.empty()) {
    const Candidate next = queue_.top();
    queue_.pop();
    if (stamp_[next.from] != next.stamp) continue;
    survey(next.from, next.to, result_.points[next.to]);
    if (const auto why = find_refusal()) {
      ++result_.refusals[static_cast<std::size_t>(*why)];
      push_next(next.from, next);
      continue;
    }
    ++result_.accepted;
    if (input_.progress) ++input_.progress->removed;
    commit();
    apply_collapse();
  }
  return result_.accepted > before;
}

// Where a point is best for what relies on the faces and borders at it, its neighbors as they are. The planes of
// the surface's own faces would not do: noise tilts them, so that they tell nothing a few faces away. Nothing where
// most of it fits already: a step in a wall that was smaller than the tolerance is no reason to tilt the wall.
std::optional<Quadric> Collapser::fit(Index a) {
  Quadric sum;
  double fitting = 0, all = 0;
  for (const Index f : star_[a]) {
    Face face = faces_[f];
    while (face[0] != a) std::rotate(face.begin(), face.begin() + 1, face.end());
    const auto [p, q, r] = corners(face);
    const Vec3 twice = cross(q - p, r - p);
    const double square = dot(twice, twice);
    if (square == 0) continue;
    const Vec3 n = (1 / std::sqrt(square)) * twice;
    containment_->visit(f, [&](const Triangle& piece) {
      const Vec3 middle = centroid(piece);
      // What a share of the point's own way moves the face there.
      const double share = dot(cross(r - q, middle - q), twice) / square;
      if (share < kLeastShare) return;
      const double off = dot(n, middle - p), weight = share * share * length(area_vector(piece));
      sum.add(n, -dot(n, p) - off / share, weight);
      all += weight;
      if (std::abs(off) < kFitting * limit_) fitting += weight;
    });
  }
  if (2 * fitting > all) return {};
  for (const Index e : rim_[a]) {
    const BorderEdge& edge = edges_[e];
    const Vec3 p = points_[a], q = points_[edge.ends[edge.ends[0] == a]], along = q - p;
    const double square = dot(along, along);
    if (square == 0) continue;
    for (const Index f : star_[a]) {
      if (!has_corner(faces_[f], edge.ends[0]) || !has_corner(faces_[f], edge.ends[1])) continue;
      const Vec3 across = cross(along, area_vector(corners(faces_[f])));
      const double size = length(across);
      if (size == 0) continue;
      const Vec3 n = (1 / size) * across;
      edge_containment_[edge.kind]->visit(e - first_edge_[edge.kind], [&](const Triangle& piece) {
        const Vec3 middle = 0.5 * (piece[0] + piece[1]);
        const double share = dot(q - middle, along) / square;
        if (share < kLeastShare) return;
        const double off = dot(n, middle - p) / share;
        sum.add(n, -dot(n, p) - off, share * share * length(piece[1] - piece[0]) * std::sqrt(square));
      });
    }
  }
  return sum;
}

bool Collapser::move(Index a) {
  const Vec3 from = points_[a];
  const auto found = fit(a);
  if (!found) return false;
  const Quadric& planes = *found;
  const double least = kWorthMoving * limit_;
  for (const double parallel : kParallel) {
    Vec3 to = planes.lowest(from, parallel);
    if (!held_[a].empty()) to = from + turn_along_planes(a, to - from);
    const double far = length(to - from);
    if (!(far > 0)) return false;
    if (far > limit_) to = from + limit_ / far * (to - from);
    const Vec3 stored = Rounding{input_.decimals, input_.single}(to + middle_);
    to = stored - middle_;
    if (!(planes.at(from) - planes.at(to) > least * least * planes.weight()) || places_.contains(stored)) continue;
    if (!keeps_planes(a, stored)) continue;
    survey(a, -1, stored);
    if (find_refusal()) continue;
    commit();
    places_.erase(result_.points[a]);
    places_.insert(stored);
    points_[a] = to;
    result_.points[a] = stored;
    ++result_.moved;
    return true;
  }
  return false;
}

void Collapser::move_all() {
  if (input_.decimals < 0) return;
  for (std::size_t p = 0; p < points_.size(); ++p) {
    const auto a = static_cast<Index>(p);
    if (star_[p].empty() || fixed_[p] || !changed_[p]) continue;
    changed_[p] = false;
    if (!move(a)) continue;
    push_from(a);
    for (const Index q : now_.ring) push_from(q);
  }
}

CollapseResult Collapser::run() {
  push_all();
  // Points that moved let others go.
  for (int round = 0; round < kMostRounds && pop_all(); ++round) move_all();
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (!alive_[f]) continue;
    result_.triangles.push_back(faces_[f]);
    result_.source.push_back(distinct_.index[f]);
    if (const Index copy = distinct_.copy[f]; copy >= 0) {
      result_.triangles.push_back({faces_[f][0], faces_[f][2], faces_[f][1]});
      result_.source.push_back(copy);
    }
  }
  return result_;
}

std::vector<Index> Collapser::holders() const {
  std::vector<Index> made(faces_.size(), -1), found;
  Index count = 0;
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (!alive_[f]) continue;
    made[f] = count;
    count += distinct_.copy[f] < 0 ? 1 : 2;
  }
  for (std::size_t f = 0; f < input_.surface.size(); ++f)
    found.push_back(made[containment_->slot_of(static_cast<Index>(f))]);
  return found;
}

double Collapser::deviation(const CollapseResult& result) const {
  const double precision = kPrecision / (1 - kPrecision) * limit_;
  const auto& faces = result.triangles;
  const DistinctFaces single = merge_copies(faces);
  std::vector<Index> label;
  for (const Index f : result.source) label.push_back(input_.label[f]);
  const auto edges = find_border_edges(single.faces, points_.size(), pair_labels(single, label));
  const auto rim = flatten_edges(edges, 0);
  // Each step holds borders to the limit. One beyond it is none: faces with the same corners have come to count as one.
  const auto held = [&](Points points, Faces border, const FaceTree& other, double known) {
    Certificate certificate(other);
    std::vector<Face> near;
    std::copy_if(border.begin(), border.end(), std::back_inserter(near),
                 [&](const Face& edge) { return certificate.holds(corners_of(edge, points), limit_); });
    return bound_distance(points, near, other, {known, precision, limit_}).distance;
  };
  const FaceTree after(points_, faces);
  double found = bound_distance(origin_, input_.surface, after, {0, precision, limit_, result.holder}).distance;
  found = bound_distance(points_, faces, *tree_, {found, precision, limit_}).distance;
  found = held(origin_, rims_[0], FaceTree(points_, rim), found);
  return held(points_, rim, *edge_tree_[0], found);
}

}  // namespace bldsimp
