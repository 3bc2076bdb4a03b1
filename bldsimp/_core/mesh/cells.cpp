#include "mesh/cells.hpp"

#include <limits>

namespace bldsimp {
namespace {

// Share of a cell's diameter: what is nearer to a cut lies on it.
constexpr double kOnCut = 1e-9;
// Sine of the angle to a cut's plane below which an edge or a face gives no cut.
constexpr double kLevel = 1e-3;
// Share of its longest side below which a cell has no area.
constexpr double kNoArea = 1e-12;
// Steps to find where two faces are equally far.
constexpr int kBisections = 30;

struct Plane {
  Vec3 through, normal;
  double height(Vec3 p) const { return dot(p - through, normal); }
  Plane turned() const { return {through, -1.0 * normal}; }
};

// Where a chord meets the outline: from this corner to the next, or at the corner itself.
struct ChordEnd {
  int before;
  bool at_corner;
  Vec3 place;
};

using Heights = std::array<double, Cell::most_corners>;

// The two ends of the chord along a plane: first the one where the outline comes up. A corner on the plane counts with
// the last one that is not. Nothing where the outline does not cross exactly twice: roundings can make that of a cell
// that is thin.
std::optional<std::array<ChordEnd, 2>> find_chord(const Cell& cell, const Plane& plane, double tiny) {
  const int n = cell.size();
  Heights height;
  for (int i = 0; i < n; ++i) height[i] = plane.height(cell[i]);
  const auto side_of = [&](int i) { return height[i] > tiny ? 1 : height[i] < -tiny ? -1 : 0; };
  int side = 0;  // of the last corner that is not on the plane; sought backwards, since GCC 12 vectorizes the other way
                 // wrongly
  for (int i = n - 1; i >= 0 && side == 0; --i) side = side_of(i);
  std::array<ChordEnd, 2> ends;
  int ups = 0, downs = 0;
  for (int i = 0; i < n; ++i) {
    const int now = side_of(i);
    if (now == 0 || now == side) continue;
    const int before = (i + n - 1) % n;
    ChordEnd& end = ends[now > 0 ? 0 : 1];
    end = {before, side_of(before) == 0, cell[before]};
    if (!end.at_corner) {
      const double share = height[before] / (height[before] - height[i]);
      end.place = cell[before] + share * (cell[i] - cell[before]);
    }
    ++(now > 0 ? ups : downs);
    side = now;
  }
  if (ups != 1 || downs != 1) return {};
  return ends;
}

// The corners after `begin` up to `end`, and the chord; nothing where those are too many.
std::optional<Cell> follow_outline(const Cell& cell, const ChordEnd& begin, const ChordEnd& end) {
  const int n = cell.size(), count = (end.before - begin.before + n - 1) % n + 1;
  if (count + 1 + !end.at_corner > Cell::most_corners) return {};
  Cell part({}, cell.depth() + 1);
  part.add(begin.place);
  for (int k = 1; k <= count; ++k) part.add(cell[(begin.before + k) % n]);
  if (!end.at_corner) part.add(end.place);
  return part;
}

std::optional<CellParts> cut_along(const Cell& cell, const Plane& plane, double tiny) {
  const auto chord = find_chord(cell, plane, tiny);
  if (!chord) return {};
  const auto& [up, down] = *chord;
  const auto above = follow_outline(cell, up, down), below = follow_outline(cell, down, up);
  if (!above || !below) return {};
  return CellParts{*below, *above};
}

double lowest(const Cell& cell, const Plane& plane) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3& p : cell.corners()) least = std::min(least, plane.height(p));
  return least;
}

// Planes along the edges of a face in a direction; the face lies below. Those of a segment are square to it, at its
// ends.
template <class Visit>
void visit_edges(const FramedTriangle& face, Vec3 up, Visit visit) {
  const Vec3 end = face.origin + face.length * face.x;
  if (face.height == 0) {
    visit(Plane{face.origin, -1.0 * face.x});
    visit(Plane{end, face.x});
    return;
  }
  const Triangle at{face.origin, end, face.origin + face.foot * face.x + face.height * face.y};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 edge = at[(i + 1) % 3] - at[i], side = cross(up, edge);
    const double size = length(side);
    if (!(size > kLevel * length(edge))) continue;
    const Plane plane{at[i], (1 / size) * side};
    const double opposite = plane.height(at[(i + 2) % 3]);
    if (std::abs(opposite) > kLevel * face.height) visit(opposite > 0 ? plane.turned() : plane);
  }
}

// Along the edge that the worst corner is farthest beyond.
std::optional<Plane> leave(const Cell& cell, const FramedTriangle& own, Vec3 up, Vec3 worst, double tiny) {
  std::optional<Plane> best;
  double most = tiny;
  visit_edges(own, up, [&](const Plane& plane) {
    const double far = plane.height(worst);
    if (!(far > most) || !(lowest(cell, plane) < -tiny)) return;
    most = far;
    best = plane;
  });
  return best;
}

// Along the edge that the worst corner is inside of and the middle farthest beyond.
std::optional<Plane> enter(const Cell& cell, const FramedTriangle& other, Vec3 up, Vec3 worst, double tiny) {
  std::optional<Plane> best;
  double most = tiny;
  visit_edges(other, up, [&](const Plane& plane) {
    const double far = plane.height(cell.middle());
    if (!(far > most) || !(plane.height(worst) < -tiny)) return;
    most = far;
    best = plane.turned();
  });
  return best;
}

// Along the line where both faces are equally far. It is found on the outline: the planes in which two planes, or two
// lines, are equally far tell less, since that is not where the faces end.
std::optional<Plane> find_middle_plane(const Cell& cell, const CellCut& cut, double tiny) {
  const auto excess = [&](Vec3 p) { return cut.own.squared_distance(p) - cut.other.squared_distance(p); };
  const int n = cell.size();
  Heights at;
  for (int i = 0; i < n; ++i) at[i] = excess(cell[i]);
  std::array<Vec3, 2> ends;
  std::size_t count = 0;
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    const bool positive = at[i] > 0;
    if (positive == (at[j] > 0)) continue;
    if (count == ends.size()) return {};
    double low = 0, high = 1;
    for (int step = 0; step < kBisections; ++step) {
      const double share = 0.5 * (low + high);
      ((excess(cell[i] + share * (cell[j] - cell[i])) > 0) == positive ? low : high) = share;
    }
    ends[count++] = cell[i] + high * (cell[j] - cell[i]);
  }
  if (count < ends.size()) return {};
  Vec3 across = cross(ends[1] - ends[0], cut.normal);
  // A cell without an area is cut across.
  if (!(length(across) > tiny)) across = cut.worst - ends[0];
  Plane plane{ends[0], normalize(across)};
  if (plane.height(cut.worst) < 0) plane = plane.turned();
  if (plane.height(cut.worst) > tiny && lowest(cell, plane) < -tiny) return plane;
  return {};
}

std::optional<CellParts> cut_along_faces(const Cell& cell, const CellCut& cut) {
  if (cell.size() + 2 > Cell::most_corners) return {};
  const double tiny = kOnCut * cell.diameter();
  const auto& [worst, normal, own, other] = cut;
  auto plane = leave(cell, own, normal, worst, tiny);
  if (!plane && own.height > 0) plane = leave(cell, own, cross(own.x, own.y), worst, tiny);
  if (!plane) plane = enter(cell, other, normal, worst, tiny);
  if (!plane && other.height > 0) plane = enter(cell, other, cross(other.x, other.y), worst, tiny);
  if (!plane) plane = find_middle_plane(cell, cut, tiny);
  if (!plane) return {};
  return cut_along(cell, *plane, tiny);
}

std::optional<CellParts> halve(const Cell& cell, Vec3 worst) {
  const int n = cell.size();
  Vec3 p = cell[0], q = cell[0];
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j)
      if (length(cell[j] - cell[i]) > length(q - p)) p = cell[i], q = cell[j];
  Plane across{0.5 * (p + q), normalize(q - p)};
  if (across.height(worst) < 0) across = across.turned();
  if (const auto parts = cut_along(cell, across, kOnCut * length(q - p))) return parts;
  if (n < 6) return {};
  // Too many corners, or too thin for roundings: from one corner to the one opposite.
  const int half = n / 2;
  CellParts parts{Cell({}, cell.depth() + 1), Cell({}, cell.depth() + 1)};
  for (int i = 0; i <= half; ++i) parts.beyond.add(cell[i]);
  for (int i = half; i <= n; ++i) parts.rest.add(cell[i % n]);
  return parts;
}

}  // namespace

Vec3 Cell::middle() const {
  Vec3 sum{0, 0, 0};
  for (const Vec3& p : corners()) sum = sum + p;
  return (1.0 / size_) * sum;
}

double Cell::diameter() const {
  double most = 0;
  for (int i = 0; i < size_; ++i)
    for (int j = i + 1; j < size_; ++j) {
      const Vec3 way = (*this)[j] - (*this)[i];
      most = std::max(most, dot(way, way));
    }
  return std::sqrt(most);
}

Vec3 find_normal(const Cell& cell, const FramedTriangle& face) {
  Vec3 twice{0, 0, 0}, along{0, 0, 0};
  for (int i = 1; i < cell.size(); ++i) {
    const Vec3 way = cell[i] - cell[0];
    if (dot(way, way) > dot(along, along)) along = way;
    if (i > 1) twice = twice + cross(cell[i - 1] - cell[0], way);
  }
  if (length(twice) > kNoArea * dot(along, along)) return normalize(twice);
  along = normalize(along);
  const Vec3 over = cross(face.x, face.y), normal = normalize(over - dot(over, along) * along);
  return normal == Vec3{0, 0, 0} ? square_to(along) : normal;
}

std::optional<CellParts> cut_cell(const Cell& cell, const CellCut& cut, double shortest) {
  if (cell.depth() >= Cell::most_depth) return {};
  if (std::max(cut.own.length, cut.other.length) > shortest)
    if (const auto parts = cut_along_faces(cell, cut)) return parts;
  return halve(cell, cut.worst);
}

}  // namespace bldsimp
