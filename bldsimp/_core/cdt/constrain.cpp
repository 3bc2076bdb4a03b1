// Step 5: segments become edges by swapping diagonals in their influence domains.

#include "cdt/cdt.hpp"
#include "cdt/legality.hpp"
#include "mesh/errors.hpp"

namespace bldsimp {
namespace {

// Influence domains of more triangles are filled anew. Swapping diagonals is faster as a rule, but takes
// quadratic time where many points bend towards the segment, or away from it.
constexpr std::size_t large = 512;

// Whether v, collinear with a and b, lies on the same side of a as b.
bool ahead(const Point2& a, const Point2& b, const Point2& v) {
  return a.x != b.x ? (b.x > a.x) == (v.x > a.x) : (b.y > a.y) == (v.y > a.y);
}

}  // namespace

// False where two segments cross that may not.
bool Triangulator::constrain(std::span<const Segment> segments, const TriangulateOptions& options) {
  collect_pending(segments);
  if (pending_.empty()) return true;
  splits_ = 0;
  most_splits_ = 100 + static_cast<std::int64_t>(pending_.size() * (pending_.size() - 1) / 2);
  few_units_ = 0x1p-50;
  mesh_.begin_marks(site_.size());
  if (!options.recover) {
    find_missing();
    return true;
  }
  while (!pending_.empty()) {
    const Pending segment = pending_.back();
    pending_.pop_back();
    Pending left = segment;
    Index crossed = -1;
    while (left.a != left.b && crossed < 0) left = realize(left, crossed);
    if (crossed < 0) continue;
    if (!options.split_crossings) {
      const Index other = use_[mesh_.mark(crossed)].segment;
      crossing_ = {std::min(use_[segment.use].segment, other), std::max(use_[segment.use].segment, other)};
      return false;
    }
    split_crossing(left, crossed);
  }
  return true;
}

// In the order of their ends on the curve, whatever the order of the input: last first, since
// pending segments are a stack.
void Triangulator::collect_pending(std::span<const Segment> segments) {
  use_.clear();
  pending_.clear();
  for (Index i = 0; i < static_cast<Index>(segments.size()); ++i) {
    const Index a = site_of_input_[segments[i][0]], b = site_of_input_[segments[i][1]];
    if (a == b) continue;
    pending_.push_back({std::min(a, b), std::max(a, b), static_cast<Index>(use_.size())});
    use_.push_back({i, -1, 1});
  }
  std::sort(pending_.begin(), pending_.end(), [](const Pending& s, const Pending& t) {
    if (s.a != t.a) return s.a > t.a;
    return s.b != t.b ? s.b > t.b : s.use > t.use;
  });
}

// Makes an edge of one end's piece of the segment, up to the first point on it, and returns what is left of
// the segment; where a constraint is in the way, `crossed` names its halfedge and nothing has changed.
Triangulator::Pending Triangulator::realize(Pending segment, Index& crossed) {
  bool fewer_at_b = false;
  Index edge = edge_between(segment.a, segment.b, fewer_at_b);
  if (fewer_at_b) std::swap(segment.a, segment.b);
  Index reached = -1;
  const Index entered = edge >= 0 ? -1 : enter(segment.a, segment.b, edge);
  if (entered >= 0) {
    reached = find_influence_domain(segment, entered, crossed);
    if (crossed >= 0) return segment;
    edge = domain_.size() > large ? fill_anew(segment.a, reached) : swap_diagonals();
  } else {
    reached = mesh_.target(edge);
  }
  mark(edge, segment.use);
  if (entered >= 0) restore_delaunay();
  return {reached, segment.b, segment.use};
}

// Adds uses to those that the edge has.
void Triangulator::mark(Index edge, Index use) {
  Index uses = mesh_.mark(edge);
  for (; use >= 0; use = use_[use].next) {
    use_.push_back({use_[use].segment, uses, uses < 0 ? 1 : use_[uses].count + 1});
    uses = static_cast<Index>(use_.size()) - 1;
  }
  mesh_.set_mark(edge, uses);
}

// Marks the segments that are edges, and lists the others.
void Triangulator::find_missing() {
  for (const Pending& segment : pending_) {
    bool fewer_at_b = false;
    const Index edge = edge_between(segment.a, segment.b, fewer_at_b);
    if (edge >= 0)
      mark(edge, segment.use);
    else
      missing_.push_back(use_[segment.use].segment);
  }
  pending_.clear();
  std::sort(missing_.begin(), missing_.end());
}

// The halfedge from a to b, or -1. Most segments of a ring are edges already, so b itself is sought first,
// without any predicate. Both fans are searched in turns: where many segments meet in a point, the smaller
// fan is found to be small. (Over all edges of a planar graph the smaller degrees add up to O(n).)
Index Triangulator::edge_between(Index a, Index b, bool& fewer_at_b) const {
  const Index from_a = mesh_.leaving(a), from_b = mesh_.leaving(b);
  for (Index h = from_a, g = from_b;;) {
    if (mesh_.target(h) == b) return h;
    if (mesh_.target(g) == a) return mesh_.twin(g);
    h = mesh_.twin(Mesh2d::prev(h));
    g = mesh_.twin(Mesh2d::prev(g));
    fewer_at_b = g == from_b && h != from_a;
    if (h == from_a || g == from_b) return -1;
  }
}

// Looks around a for the way to b: the halfedge that a-b crosses first, or -1 and in `edge` the
// one from a that lies on a-b.
Index Triangulator::enter(Index a, Index b, Index& edge) const {
  const Index first = mesh_.leaving(a);
  Index h = first;
  do {
    const Index u = mesh_.target(h), w = mesh_.apex(h);
    if (u >= 0) {
      const int side = orient2d(site_[a], site_[b], site_[u]);
      if (side == 0 && ahead(site_[a], site_[b], site_[u])) {
        edge = h;
        return -1;
      }
      if (side < 0 && w >= 0 && orient2d(site_[a], site_[b], site_[w]) > 0) return Mesh2d::next(h);
    }
    h = mesh_.twin(Mesh2d::prev(h));
  } while (h != first);
  throw InternalError("triangulate", "no triangle around a point sees the end of its segment");
}

// Collects the triangles that the segment crosses, up to the first point on it, and the chains of
// their edges on its left, from there back, and on its right. Changes nothing in the net.
Index Triangulator::find_influence_domain(Pending segment, Index entered, Index& crossed) {
  const Point2 &a = site_[segment.a], &b = site_[segment.b];
  chain_.assign(1, Mesh2d::next(entered));
  right_chain_.assign(1, Mesh2d::prev(entered));
  domain_.assign(1, Mesh2d::triangle(entered));
  for (Index h = entered;;) {
    if (mesh_.mark(h) >= 0) {
      crossed = h;
      return -1;
    }
    const Index g = mesh_.twin(h);
    const Index far = mesh_.apex(g);
    domain_.push_back(Mesh2d::triangle(g));
    const int side = far == segment.b ? 0 : orient2d(a, b, site_[far]);
    if (side <= 0) right_chain_.push_back(Mesh2d::next(g));
    if (side < 0) {
      h = Mesh2d::prev(g);
      continue;
    }
    chain_.push_back(Mesh2d::prev(g));
    if (side == 0) return far;
    h = Mesh2d::next(g);
  }
}

// Swaps diagonals until the two ends of the chain share an edge; returns its halfedge from the end.
// Like the scan for a convex hull: a vertex of the chain whose angle towards the segment is less
// than two right angles is cut off. The farthest one always is such, so none remains.
Index Triangulator::swap_diagonals() {
  std::size_t size = 0;
  for (const Index link : chain_) {
    chain_[size++] = link;
    while (size > 1) {
      const Index after = chain_[size - 1], before = chain_[size - 2];
      const Index u = mesh_.target(before), v = mesh_.origin(before), w = mesh_.origin(after);
      if (orient2d(site_[u], site_[v], site_[w]) >= 0) break;
      chain_[size - 2] = cut_off(before, after);
      --size;
    }
  }
  if (size != 1) throw InternalError("triangulate", "an influence domain has no diagonal along its segment");
  return chain_[0];
}

// Cuts the vertex v at which `after` (w to v) meets `before` (v to u) off the influence domain, by
// flipping the diagonals that leave it, and returns the halfedge from w to u inside the domain.
// Diagonal v-x goes where the far ends of the fan turn convexly at x. Some x always does: the fan's
// rim starts and ends on v's side of the segment and lies beyond it in between.
Index Triangulator::cut_off(Index before, Index after) {
  Index spoke = mesh_.twin(Mesh2d::prev(before));
  while (Mesh2d::prev(before) != after) {
    const Index b = mesh_.twin(spoke);
    const Index w = mesh_.apex(b), x = mesh_.target(spoke), y = mesh_.apex(spoke);
    const bool last = Mesh2d::prev(spoke) == after;
    if (orient2d(site_[w], site_[x], site_[y]) <= 0) {
      if (last) throw InternalError("triangulate", "no diagonal of a fan can be swapped");
      spoke = mesh_.twin(Mesh2d::prev(spoke));
      continue;
    }
    mesh_.flip<true>(spoke);
    ++statistics_.flips;
    if (last) after = b;
    // The triangle of v is now b's: y to v, v to w.
    const Index rim_start = Mesh2d::next(b);
    spoke = rim_start == before ? mesh_.twin(b) : rim_start;
  }
  return mesh_.twin(Mesh2d::next(before));
}

// Triangulates both sides of a large influence domain by themselves, and returns a halfedge along the
// segment. What is Delaunay among many points is so among few of them, hence the rim of a side needs no
// swaps there but at other constraints, and the segment is an edge of its hull.
Index Triangulator::fill_anew(Index from, Index reached) {
  rim_.clear();
  note_rim(chain_);
  note_rim(right_chain_);
  std::sort(rim_.begin(), rim_.end(), [](const RimEdge& e, const RimEdge& f) {
    return e.origin != f.origin ? e.origin < f.origin : e.target < f.target;
  });
  std::vector<Index> left, right;
  for (auto link = chain_.rbegin(); link != chain_.rend(); ++link) left.push_back(mesh_.origin(*link));
  for (const Index link : right_chain_) right.push_back(mesh_.origin(link));
  left.push_back(from);
  right.push_back(reached);
  std::size_t filled = 0;
  const Index on_left = fill_side(left, filled), on_right = fill_side(right, filled);
  if (filled != domain_.size()) throw InternalError("triangulate", "an influence domain was not filled");
  mesh_.join(on_left, on_right, -1);
  return on_left;
}

void Triangulator::note_rim(Indices chain) {
  for (const Index h : chain) rim_.push_back({mesh_.origin(h), mesh_.target(h), mesh_.twin(h), mesh_.mark(h)});
}

// Puts the triangles inside a ring into the triangles of the domain from `filled` on; returns the halfedge
// from the ring's last site to its first, which is the segment. An edge that the ring passes both ways has
// triangles of the domain on both sides.
Index Triangulator::fill_side(Indices ring, std::size_t& filled) {
  std::vector<Point2> points;
  std::vector<double> lift;
  std::vector<Segment> segments;
  for (const Index site : ring) {
    const auto row = static_cast<Index>(points.size());
    points.push_back(site_[site]);
    if (!lift_.empty()) lift.push_back(lift_[site]);
    segments.push_back({row, (row + 1) % static_cast<Index>(ring.size())});
  }
  if (!side_) side_ = std::make_unique<Triangulator>();
  if (side_->run(points, segments, {.lift = lift_.empty() ? nullptr : lift.data()}) != Status::done)
    throw InternalError("triangulate", "the rim of an influence domain crosses itself");
  statistics_.flips += side_->statistics().flips;
  const auto& triangles = side_->triangles();
  const std::size_t first = filled;
  filled += triangles.size();
  if (filled > domain_.size()) throw InternalError("triangulate", "an influence domain was filled more than once");
  for (std::size_t row = 0; row < triangles.size(); ++row) {
    const auto& [a, b, c] = triangles[row];
    mesh_.replace(domain_[first + row], {ring[a], ring[b], ring[c]});
  }
  Index along = -1;
  for (Index row = 0; row < static_cast<Index>(triangles.size()); ++row)
    for (Index i = 0; i < 3; ++i) {
      const Index h = 4 * domain_[first + row] + i, across = side_->neighbors()[row][(i + 2) % 3];
      const auto edge = std::array{mesh_.origin(h), mesh_.target(h)};
      const auto at = std::lower_bound(rim_.begin(), rim_.end(), edge, [](const RimEdge& e, const auto& ends) {
        return e.origin != ends[0] ? e.origin < ends[0] : e.target < ends[1];
      });
      const bool on_rim = at != rim_.end() && at->origin == edge[0] && at->target == edge[1];
      if (across >= 0) {
        const auto& beyond = triangles[across];
        const auto end = std::find(beyond.begin(), beyond.end(), triangles[row][(i + 1) % 3]);
        mesh_.join(h, 4 * domain_[first + across] + static_cast<Index>(end - beyond.begin()), on_rim ? at->uses : -1);
      } else if (on_rim) {
        mesh_.join(h, at->twin, at->uses);
      } else {
        along = h;
      }
    }
  return along;
}

// Lawson flips on every edge of the influence domain that is not a constraint.
void Triangulator::restore_delaunay() {
  stack_.clear();
  for (const Index t : domain_)
    for (Index i = 0; i < 3; ++i) stack_.push_back(4 * t + i);
  legalize_edges();
}

void Triangulator::legalize_edges() {
  while (!stack_.empty()) {
    const Index h = stack_.back();
    stack_.pop_back();
    if (!wants_flip<true>(h)) continue;
    const Index b = mesh_.twin(h);
    mesh_.flip<true>(h);
    ++statistics_.flips;
    stack_.insert(stack_.end(), {h, Mesh2d::next(h), b, Mesh2d::next(b)});
  }
}

// Bends the segment and the constraint that it crosses to one point: their crossing, rounded, or a
// point that both nearly pass. That point lies in the boxes of both, so that each of the two is
// replaced by two shorter ones, or kept where the point is one of its ends, which cannot happen to
// both: hence this ends, whatever rounding does. It would not end soon without the points nearly
// passed: of three lines that nearly meet in a point, two would march along the third, a unit in the
// last place at a time, and nearly parallel ones along each other.
void Triangulator::split_crossing(Pending segment, Index crossed) {
  const Pending other{mesh_.origin(crossed), mesh_.target(crossed), mesh_.mark(crossed)};
  const Point2 point = crossing_point(segment, other);
  const Index near = Mesh2d::next(crossed);
  mesh_.set_mark(crossed, -1);
  stack_.assign(1, crossed);
  legalize_edges();
  const Location location = locate(point, near);
  Index v = point_nearby(point, location, segment, other);
  if (v < 0) {
    v = static_cast<Index>(site_.size());
    site_.push_back(point);
    input_.push_back(static_cast<Index>(points_.size()));
    points_.push_back(point);
    if (!lift_.empty()) lift_.push_back(lift_on(segment, point));
    insert<true>(v, location);
  }
  for (const Pending& part : {Pending{other.a, v, other.use}, Pending{v, other.b, other.use},
                              Pending{segment.a, v, segment.use}, Pending{v, segment.b, segment.use}})
    if (part.a != part.b) pending_.push_back(part);
}

// The box that two crossing segments have in common.
Triangulator::Box2 Triangulator::common_box(Pending s, Pending t) const {
  const auto [s_x, s_right] = std::minmax(site_[s.a].x, site_[s.b].x);
  const auto [t_x, t_right] = std::minmax(site_[t.a].x, site_[t.b].x);
  const auto [s_y, s_top] = std::minmax(site_[s.a].y, site_[s.b].y);
  const auto [t_y, t_top] = std::minmax(site_[t.a].y, site_[t.b].y);
  return {{std::max(s_x, t_x), std::max(s_y, t_y)}, {std::min(s_right, t_right), std::min(s_top, t_top)}};
}

Point2 Triangulator::crossing_point(Pending s, Pending t) const {
  const Point2 &a = site_[s.a], &b = site_[s.b];
  const double at_a = exact::area2(site_[t.a], site_[t.b], a);
  const double at_b = exact::area2(site_[t.a], site_[t.b], b);
  const double share = at_a / (at_a - at_b);
  const Box2 box = common_box(s, t);
  const auto along = [share](double from, double to, double least, double most) {
    const double value = from + share * (to - from);
    // Not a number where areas overflow: any point of the box will do.
    return value == value ? std::clamp(value, least, most) : least;
  };
  return {along(a.x, b.x, box.least.x, box.most.x), along(a.y, b.y, box.least.y, box.most.y)};
}

// A site in both boxes that is the point or, up to a few units in the last place, at the point or
// an end of one segment on the other; -1 for none. More crossings than there are pairs of segments mean
// that rounding makes new ones: then "few" becomes more.
Index Triangulator::point_nearby(const Point2& point, Location location, Pending s, Pending t) {
  if (location.place == Place::at_vertex) return mesh_.origin(location.halfedge);
  if (++splits_ > most_splits_) {
    most_splits_ += most_splits_ / 4;
    few_units_ *= 2.0;
  }
  double size = 0.0;
  for (const Index end : {s.a, s.b, t.a, t.b}) size = std::max({size, std::abs(site_[end].x), std::abs(site_[end].y)});
  const double near = few_units_ * size;
  const Box2 box = common_box(s, t);
  const auto in_box = [&](const Point2& p) {
    return box.least.x <= p.x && p.x <= box.most.x && box.least.y <= p.y && p.y <= box.most.y;
  };
  const auto on = [&](Index site, Pending segment) {
    const Point2 &a = site_[segment.a], &b = site_[segment.b];
    const double area = exact::area2(a, b, site_[site]);
    return in_box(site_[site]) && std::abs(area) <= near * std::hypot(b.x - a.x, b.y - a.y);
  };
  for (const Index site : {s.a, s.b})
    if (on(site, t)) return site;
  for (const Index site : {t.a, t.b})
    if (on(site, s)) return site;
  const Index h = location.halfedge;
  for (const Index site : {mesh_.origin(h), mesh_.target(h), mesh_.apex(h)}) {
    if (site < 0 || !in_box(site_[site])) continue;
    if (std::abs(site_[site].x - point.x) <= near && std::abs(site_[site].y - point.y) <= near) return site;
  }
  return -1;
}

double Triangulator::lift_on(Pending segment, const Point2& point) const {
  const Point2 &a = site_[segment.a], &b = site_[segment.b];
  const bool along_x = std::abs(b.x - a.x) >= std::abs(b.y - a.y);
  const double share = along_x ? (point.x - a.x) / (b.x - a.x) : (point.y - a.y) / (b.y - a.y);
  return lift_[segment.a] + share * (lift_[segment.b] - lift_[segment.a]);
}

}  // namespace bldsimp
