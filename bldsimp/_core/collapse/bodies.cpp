#include "collapse/bodies.hpp"

#include <tuple>

#include "mesh/edges.hpp"
#include "mesh/index_sets.hpp"
#include "mesh/vertical_ray.hpp"

namespace bldsimp {
namespace {

// Directions this near each other, as shares of a quarter turn, are one. It only decides what hangs together, and
// whoever takes a body away looks at what that leaves.
constexpr double kSame = 1e-6;
// A closed body whose volume is less than this share of what adds up to it has none.
constexpr double kNoVolume = 1e-9;

// A face at an edge that is looked along: where it is on the way round, from 0 to 4; matter lies before it or after.
struct Spoke {
  double turn;
  bool before;
  Index halfedge;
};

// Rises with the angle of (x, y) from 0 to 4 without a call whose last bits depend on the machine.
double turn_of(double x, double y) {
  const double size = std::abs(x) + std::abs(y);
  if (size == 0) return 0;
  const double part = y / size;
  if (x < 0) return 2 - part;
  return part < 0 ? 4 + part : part;
}

class SpokePairing {
 public:
  SpokePairing(Points points, Faces faces) : points_(points), faces_(faces) {}

  // Calls join(f, g) for the faces at an edge that bound the same matter.
  template <class Join>
  void pair(Indices edge, Join join) {
    if (!lay(edge)) return;
    open_.clear();
    // Going round twice closes what the beginning cuts.
    for (int round = 0; round < 2; ++round)
      for (Spoke& spoke : spokes_) {
        if (spoke.halfedge < 0) continue;
        if (!spoke.before) {
          if (round == 0) open_.push_back(&spoke);
        } else if (!open_.empty()) {
          join(open_.back()->halfedge / 3, spoke.halfedge / 3);
          open_.back()->halfedge = spoke.halfedge = -1;
          open_.pop_back();
        }
      }
  }

 private:
  // The spokes in order; where several lie in one direction, those before which matter lies come first. False where
  // there are not as many of either kind.
  bool lay(Indices edge) {
    const auto [a, b] = std::minmax({origin(faces_, edge[0]), target(faces_, edge[0])});
    const Vec3 along = points_[b] - points_[a];
    const double squared = dot(along, along);
    if (squared == 0) return false;
    const auto away = [&](Index h) {
      const Vec3 way = points_[apex(faces_, h)] - points_[a];
      return way - (dot(way, along) / squared) * along;
    };
    const auto farther = [&](Index h, Index g) {
      const Vec3 p = away(h), q = away(g);
      return std::tuple(-dot(p, p), apex(faces_, h)) < std::tuple(-dot(q, q), apex(faces_, g));
    };
    const Vec3 x = away(*std::min_element(edge.begin(), edge.end(), farther)),
               y = (1 / std::sqrt(squared)) * cross(along, x);
    spokes_.clear();
    std::size_t before = 0;
    for (const Index h : edge) {
      const Vec3 way = away(h);
      spokes_.push_back({turn_of(dot(way, x), dot(way, y)), origin(faces_, h) == a, h});
      before += spokes_.back().before;
    }
    if (2 * before != edge.size()) return false;
    std::sort(spokes_.begin(), spokes_.end(), [&](const Spoke& s, const Spoke& t) {
      return std::tuple(s.turn, apex(faces_, s.halfedge), s.halfedge) <
             std::tuple(t.turn, apex(faces_, t.halfedge), t.halfedge);
    });
    const auto parts = [](const Spoke& s, const Spoke& t) { return t.turn - s.turn > kSame; };
    // The beginning must not part what lies in one direction.
    if (spokes_.front().turn + 4 - spokes_.back().turn <= kSame)
      for (std::size_t i = 1; i < spokes_.size(); ++i)
        if (parts(spokes_[i - 1], spokes_[i])) {
          for (std::size_t j = 0; j < i; ++j) spokes_[j].turn += 4;
          std::rotate(spokes_.begin(), spokes_.begin() + static_cast<std::ptrdiff_t>(i), spokes_.end());
          break;
        }
    for (auto from = spokes_.begin(); from != spokes_.end();) {
      auto to = from + 1;
      while (to != spokes_.end() && !parts(*(to - 1), *to)) ++to;
      std::stable_partition(from, to, [](const Spoke& s) { return s.before; });
      from = to;
    }
    return true;
  }

  Points points_;
  Faces faces_;
  std::vector<Spoke> spokes_;
  std::vector<Spoke*> open_;
};

// Finds inner shells: closed bodies that face inwards, within closed ones that face outwards.
class ShellFinder {
 public:
  ShellFinder(Points points, Faces faces, Indices body)
      : points_(points), faces_(faces), body_(body), volume_(faces.size(), 0) {}

  // Calls join(f, g) for a face of each inner shell and one of the body around it.
  template <class Join>
  void find(Join join) {
    measure_volumes();
    if (std::none_of(volume_.begin(), volume_.end(), [](double v) { return v < 0; })) return;
    forget_open_bodies();
    std::vector<Index> outer;
    for (std::size_t f = 0; f < faces_.size(); ++f)
      if (volume_[body_[f]] > 0) outer.push_back(static_cast<Index>(f));
    const BoxTree tree(points_, faces_, std::move(outer));
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      const auto shell = static_cast<Index>(f);
      if (volume_[f] >= 0) continue;
      if (const Index around = find_around(shell, tree); around >= 0) join(shell, around);
    }
  }

 private:
  // Six times the volume of each body, at its least face, from a corner of that; 0 where that is a mere rounding.
  void measure_volumes() {
    std::vector<double> magnitude(faces_.size(), 0);
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      const Vec3 base = points_[faces_[body_[f]][0]];
      const double part = dot(points_[faces_[f][0]] - base, area_vector(corners_of(faces_[f], points_)));
      volume_[body_[f]] += part, magnitude[body_[f]] += std::abs(part);
    }
    for (std::size_t f = 0; f < faces_.size(); ++f)
      if (std::abs(volume_[f]) <= kNoVolume * magnitude[f]) volume_[f] = 0;
  }

  // Open bodies have none: on some edge more of their faces run one way than the other.
  void forget_open_bodies() {
    const auto count = static_cast<Index>(points_.size());
    std::vector<std::pair<Index, int>> ways;
    EdgeBuckets(faces_, count).visit(0, count, [&](Indices edge) {
      ways.clear();
      for (const Index h : edge) ways.push_back({body_[h / 3], origin(faces_, h) < target(faces_, h) ? 1 : -1});
      for_unbalanced(ways, [&](Index open) { volume_[open] = 0; });
    });
  }

  // The smallest body around a shell, or -1.
  Index find_around(Index shell, const BoxTree& tree) const {
    std::vector<std::pair<Index, int>> crossings;
    visit_above(centroid(corners_of(faces_[shell], points_)), tree, points_, faces_,
                [&](Index f, int way) { crossings.push_back({body_[f], way}); });
    Index around = -1;
    for_unbalanced(crossings, [&](Index b) {
      if (volume_[b] > -volume_[shell] && (around < 0 || volume_[b] < volume_[around])) around = b;
    });
    return around;
  }

  Points points_;
  Faces faces_;
  Indices body_;
  std::vector<double> volume_;
};

}  // namespace

Array<Index> find_bodies(Points points, Faces faces) {
  IndexSets sets(faces.size());
  SpokePairing edges(points, faces);
  const auto join = [&](Index f, Index g) { sets.join(f, g); };
  const auto count = static_cast<Index>(points.size());
  EdgeBuckets(faces, count).visit(0, count, [&](Indices edge) {
    if (edge.size() == 2) join(edge[0] / 3, edge[1] / 3);
    if (edge.size() > 2) edges.pair(edge, join);
  });
  const Array<Index> body = IndexSets(sets).roots();
  ShellFinder(points, faces, body).find(join);
  return std::move(sets).roots();
}

}  // namespace bldsimp
