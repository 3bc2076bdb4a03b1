#include "mesh/certificate.hpp"

#include <atomic>
#include <limits>

#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

// Cells of one triangle: more than any but a made-up case needs. What is left then counts as it is.
constexpr std::size_t kMostCells = 1 << 16;

// A bound looks at so many places first.
constexpr std::size_t kPlaces = 50000;

// Faces for one thread at least.
constexpr std::size_t kLeastFaces = 64;

// A cell so many times longer than its face covers several, and a panel may hold it at once.
constexpr double kMany = 1.2;

// What is within this share of the limit is near enough: the nearest of all would hold little more.
constexpr double kNear = 0.25;

double largest_coordinate(const Triangle& triangle) {
  double most = 0;
  for (const Vec3& p : triangle) most = std::max({most, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return most;
}

}  // namespace

void Certificate::start(const Triangle& triangle) {
  const FramedTriangle own(triangle[0], triangle[1], triangle[2]);
  normal_ = own.height > 1e-12 * own.length ? cross(own.x, own.y) : Vec3{0, 0, 0};
  blur_ = Cell::rounding * largest_coordinate(triangle);
  left_.clear();
}

Certificate::MeasuredCell Certificate::measure(const Cell& cell, Index place) {
  ++cells_;
  const FramedTriangle& face = surface_.triangle(place);
  int worst = 0;
  double most = -1;
  for (int i = 0; i < cell.size(); ++i)
    if (const double square = face.squared_distance(cell[i]); square > most) most = square, worst = i;
  return {cell, place, worst, std::sqrt(most) + blur(cell)};
}

// Takes another face if that one is nearer to all of the cell; whether it is.
bool Certificate::improve(MeasuredCell& cell, Index place) {
  if (place == cell.place) return false;
  const MeasuredCell other = measure(cell.cell, place);
  if (!(other.most < cell.most)) return false;
  cell = other;
  return true;
}

std::optional<CellParts> Certificate::cut(const MeasuredCell& cell, Index other, double shortest) const {
  const FramedTriangle& own = surface_.triangle(cell.place);
  const Vec3 normal = normal_ == Vec3{0, 0, 0} ? find_normal(cell.cell, own) : normal_;
  return cut_cell(cell.cell, {cell.cell[cell.worst], normal, own, surface_.triangle(other)}, shortest);
}

// The farthest cell is cut first, so that what is left is a bound whenever one stops.
double Certificate::bound(const Triangle& triangle, double enough, double precision, Index guess) {
  if (surface_.order().empty()) return kFar;
  start(triangle);
  precision = std::max(precision, Cell::most_depth * blur_);
  MeasuredCell first = measure(Cell(triangle), surface_.place_of(guess));
  if (first.most <= enough) return first.most;
  double least = 0;    // that the greatest distance is; only tells when to stop
  double settled = 0;  // bound of cells that are not cut again
  const auto stop = [&] { return std::max(enough, least + precision); };
  const auto add = [&](MeasuredCell cell) {
    if (cell.most > stop()) {
      const Vec3 middle = cell.cell.middle();
      Index place = cell.place;
      const double at_middle = surface_.nearest(middle, place);
      least = std::max(least, at_middle);
      improve(cell, place);
      // No point is farther than another one and the way there.
      double way = 0;
      for (const Vec3& p : cell.cell.corners()) way = std::max(way, length(p - middle));
      cell.most = std::min(cell.most, at_middle + way + blur(cell.cell));
    }
    left_.push_back(cell);
    std::push_heap(left_.begin(), left_.end());
  };
  add(first);
  while (!left_.empty() && left_.front().most > std::max(stop(), settled) && left_.size() < kMostCells) {
    std::pop_heap(left_.begin(), left_.end());
    const MeasuredCell cell = left_.back();
    left_.pop_back();
    Index other = cell.place;
    least = std::max(least, surface_.nearest(cell.cell[cell.worst], other));
    const auto parts = cell.most > stop() ? cut(cell, other, 0) : std::nullopt;
    if (!parts) {
      settled = std::max(settled, cell.most);
      continue;
    }
    add(measure(parts->rest, cell.place));
    add(measure(parts->beyond, other));
  }
  return std::max(settled, left_.empty() ? 0.0 : left_.front().most);
}

// Whether a cell that covers many faces is held by a panel.
bool Certificate::many_hold(const MeasuredCell& cell, double limit) const {
  const double size = cell.cell.diameter();
  if (!(size > kMany * surface_.triangle(cell.place).length)) return false;
  return surface_.panel_holds(cell.cell.corners(), cell.cell.middle(), size, limit - blur(cell.cell));
}

// A point of a cell that is too far of all faces refutes; the faces nearest to its middle and to its worst corner prove
// most cells, and tell where to cut the others.
bool Certificate::holds(const Triangle& triangle, double limit, Index guess) {
  if (surface_.order().empty()) return false;
  start(triangle);
  const double near = kNear * limit;
  left_.push_back(measure(Cell(triangle), surface_.place_of(guess)));
  while (!left_.empty()) {
    MeasuredCell cell = left_.back();
    left_.pop_back();
    if (cell.most <= limit || many_hold(cell, limit)) continue;
    Index inside = cell.place;
    if (surface_.nearest(cell.cell.middle(), inside, near) > limit) return false;
    if (improve(cell, inside) && cell.most <= limit) continue;
    Index other = cell.place;
    if (surface_.nearest(cell.cell[cell.worst], other, near) > limit) return false;
    const int worst = cell.worst;
    if (improve(cell, other)) {
      if (cell.most <= limit) continue;
      if (cell.worst != worst && surface_.nearest(cell.cell[cell.worst], other, near) > limit) return false;
    }
    if (cell.cell.diameter() < limit * finest) return false;
    // Cells along the edges of faces that are shorter than the limit would be no larger than halves.
    const auto parts = cut(cell, other, limit);
    if (!parts) return false;
    left_.push_back(measure(parts->rest, cell.place));
    left_.push_back(measure(parts->beyond, other));
  }
  return true;
}

bool Certificate::holds(std::span<const Triangle> region, double limit, Index guess) {
  return std::all_of(region.begin(), region.end(), [&](const Triangle& t) { return holds(t, limit, guess); });
}

SurfaceBound bound_distance(Points points, Faces faces, const FaceTree& other, const BoundGoal& goal) {
  // The distances of some places tell how little there is no need to look at closely.
  std::vector<Vec3> some;
  for (std::size_t f = 0; f < faces.size(); f += 1 + faces.size() / kPlaces) {
    const Triangle own = corners_of(faces[f], points);
    some.insert(some.end(), {own[0], centroid(own)});
  }
  const double enough = std::max(goal.known, other.farthest(some, kFar) + goal.precision);
  std::vector<SurfaceBound> own(faces.size());
  parallel_for(
      faces.size(),
      [&](std::size_t begin, std::size_t end) {
        Certificate certificate(other);
        for (std::size_t f = begin; f < end; ++f) {
          const std::int64_t before = certificate.cells();
          const Triangle triangle = corners_of(faces[f], points);
          const Index guess = goal.guesses.empty() ? 0 : goal.guesses[f];
          own[f].distance = certificate.bound(triangle, enough, goal.precision, guess);
          if (own[f].distance > goal.limit && certificate.holds(triangle, goal.limit, guess))
            own[f].distance = goal.limit;
          own[f].cells = certificate.cells() - before;
        }
      },
      kLeastFaces);
  SurfaceBound found{goal.known, 0};
  for (const SurfaceBound& one : own) found = {std::max(found.distance, one.distance), found.cells + one.cells};
  return found;
}

bool stays_within(Points points, Faces faces, const FaceTree& other, double limit) {
  std::atomic<bool> beyond = false;
  parallel_for(
      faces.size(),
      [&](std::size_t begin, std::size_t end) {
        Certificate certificate(other);
        for (std::size_t f = begin; f < end && !beyond; ++f)
          if (!certificate.holds(corners_of(faces[f], points), limit)) beyond = true;
      },
      kLeastFaces);
  return !beyond;
}

}  // namespace bldsimp
