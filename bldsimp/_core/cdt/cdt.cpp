#include "cdt/cdt.hpp"

#include "cdt/legality.hpp"
#include "mesh/errors.hpp"

namespace bldsimp {

Status Triangulator::run(std::span<const Point2> points, std::span<const Segment> segments,
                         const TriangulateOptions& options) {
  statistics_ = {};
  crossing_ = {-1, -1};
  poles_ = options.poles;
  pieces_.clear();
  missing_.clear();
  triangles_.clear();
  neighbors_.clear();
  merge_points(points, options.lift);
  if (!insert_points()) return Status::done;
  if (!constrain(segments, options)) return Status::crossing;
  if (!missing_.empty()) return Status::done;
  emit(options.carve);
  emit_pieces(segments);
  return Status::done;
}

// Sites are the distinct points in the order of insertion.
void Triangulator::merge_points(std::span<const Point2> points, const double* lift) {
  points_.assign(points.begin(), points.end());
  site_.clear();
  lift_.clear();
  input_.clear();
  site_of_input_.resize(points.size());
  point_of_input_.resize(points.size());
  for (const Index row : hilbert_.order(points)) {
    if (site_.empty() || !(site_.back() == points[row])) {
      site_.push_back(points[row]);
      input_.push_back(row);
      if (lift != nullptr) lift_.push_back(lift[row]);
    }
    site_of_input_[row] = static_cast<Index>(site_.size()) - 1;
    point_of_input_[row] = input_.back();
  }
}

// Steps 1 to 4. False where all points are collinear.
bool Triangulator::insert_points() {
  const auto count = static_cast<Index>(site_.size());
  mesh_.clear(2 * site_.size() + 2);
  Index third = 2;
  int turn = 0;
  while (third < count && (turn = orient2d(site_[0], site_[1], site_[third])) == 0) ++third;
  if (third >= count) return false;
  mesh_.found(0, turn > 0 ? 1 : third, turn > 0 ? third : 1);
  Index last = 0;
  for (Index site = 2; site < count; ++site)
    if (site != third) last = insert<false>(site, locate(site_[site], last));
  return true;
}

// Step 2: on which side of the halfedge the target is. Where the two products differ in sign, its
// ends lie in neighboring quadrants around the target: then all three occur among the poles, and
// only the signs of differences, which are comparisons, decide. Those cases cost nothing here, since
// the filter passes them all. Only where it fails are the poles looked at one by one, before the exact
// predicate: asking them first for every edge took 413 ms for a million points, this 355 ms.
int Triangulator::direction(Index h, const Point2& target) {
  const Point2 &a = site_[mesh_.origin(h)], &b = site_[mesh_.target(h)];
  const double left = (a.x - target.x) * (b.y - target.y);
  const double right = (a.y - target.y) * (b.x - target.x);
  const double determinant = left - right;
  const double bound = filter::orient2d * (std::abs(left) + std::abs(right)) + filter::floor2;
  if (std::abs(determinant) > bound) {
    const bool told = ((left < 0.0) & (right > 0.0)) | ((left > 0.0) & (right < 0.0));
    statistics_.by_poles += told & poles_;
    statistics_.by_determinant += !(told & poles_);
    return determinant > 0.0 ? 1 : -1;
  }
  const int by_poles = poles_ ? direction_by_poles(a, b, target) : 0;
  ++(by_poles != 0 ? statistics_.by_poles : statistics_.by_determinant);
  return by_poles != 0 ? by_poles : exact::orient2d(a, b, target);
}

// Step 3: from the triangle of `start` across the edge that sees the target on its other side. In
// a Delaunay net no such walk returns to a triangle; in a constrained one it might, so it is bounded.
Triangulator::Location Triangulator::locate(const Point2& target, Index start) {
  ++statistics_.located;
  Index h = start;
  if (mesh_.ghost(Mesh2d::triangle(h))) {
    while (mesh_.origin(h) < 0 || mesh_.target(h) < 0) h = Mesh2d::next(h);
    h = mesh_.twin(h);
  }
  int here = direction(h, target);
  if (here < 0) {
    h = mesh_.twin(h);
    here = 1;
  }
  for (Index steps = mesh_.size(); steps > 0; --steps) {
    if (mesh_.apex(h) < 0) return {Place::outside, h};
    const Index after = Mesh2d::next(h), before = Mesh2d::prev(h);
    const int at_after = direction(after, target);
    if (at_after < 0) {
      h = mesh_.twin(after);
      here = 1;
      ++statistics_.walked;
      continue;
    }
    const int at_before = direction(before, target);
    if (at_before < 0) {
      h = mesh_.twin(before);
      here = 1;
      ++statistics_.walked;
      continue;
    }
    return settle(h, here, at_after, at_before);
  }
  return locate_by_scan(target);
}

// The target lies in the closed triangle of h; the directions of its edges say where.
Triangulator::Location Triangulator::settle(Index h, int here, int at_after, int at_before) {
  if (here == 0 && at_before == 0) return {Place::at_vertex, h};
  if (here == 0 && at_after == 0) return {Place::at_vertex, Mesh2d::next(h)};
  if (at_after == 0 && at_before == 0) return {Place::at_vertex, Mesh2d::prev(h)};
  if (here == 0) return {Place::on_edge, h};
  if (at_after == 0) return {Place::on_edge, Mesh2d::next(h)};
  if (at_before == 0) return {Place::on_edge, Mesh2d::prev(h)};
  return {Place::inside, h};
}

// Looks at every triangle: ends whatever the net.
Triangulator::Location Triangulator::locate_by_scan(const Point2& target) {
  for (Index t = 0; t < mesh_.size(); ++t) {
    const Index h = 4 * t;
    if (mesh_.ghost(t)) continue;
    const int here = direction(h, target);
    const int at_after = here < 0 ? -1 : direction(h + 1, target);
    const int at_before = at_after < 0 ? -1 : direction(h + 2, target);
    if (at_before >= 0) return settle(h, here, at_after, at_before);
  }
  for (Index h = 0; h < 4 * mesh_.size(); h = (h & 3) == 2 ? h + 2 : h + 1)
    if (mesh_.apex(h) < 0 && direction(h, target) > 0) return {Place::outside, h};
  throw InternalError("triangulate", "a point is in no triangle of the net");
}

// The criterion of (x, y, lift). Rounded lifts need not be convex, so the four must be.
// Every flip lowers the lifted surface (with the ties' perturbation), hence flipping ends.
bool Triangulator::lifted_wants_flip(Index p, Index a, Index b, Index q) const {
  if (orient2d(site_[p], site_[a], site_[q]) <= 0 || orient2d(site_[q], site_[b], site_[p]) <= 0) return false;
  const auto lifted = [&](Index i) { return Point3{site_[i].x, site_[i].y, lift_[i]}; };
  const int side = orient3d(lifted(p), lifted(a), lifted(b), lifted(q));
  return side > 0 || (side == 0 && holds_least(p, a, b, q));
}

// Whether the diagonal p-q holds the lexicographically least of the four points.
bool Triangulator::holds_least(Index p, Index a, Index b, Index q) const {
  const Point2& least_pq = lexicographically_less(site_[p], site_[q]) ? site_[p] : site_[q];
  const Point2& least_ab = lexicographically_less(site_[a], site_[b]) ? site_[a] : site_[b];
  return lexicographically_less(least_pq, least_ab);
}

}  // namespace bldsimp
