#include "mesh/crossings.hpp"

#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

constexpr std::size_t kBlock = 512;

double largest(Vec3 a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }

// Bounds the rounding error of (x - p) * (d x e), where x - p, d and e may each be off by a rounding and no
// coordinate of d and e is greater than these; infinite where it could overflow. As in `predicates.hpp`.
double error(Vec3 way, double d, double e) {
  constexpr double share = 2 * 8 * filter::unit;
  const double permanent = d * e * (std::abs(way.x) + std::abs(way.y) + std::abs(way.z));
  return permanent < filter::large ? share * permanent + filter::floor4 : std::numeric_limits<double>::infinity();
}

// Sign of a value that may be off by `bound`; 0 if it cannot be told.
int sign_beyond(double value, double bound) { return value > bound ? 1 : value < -bound ? -1 : 0; }

// A triangle and its normal, rounded.
struct OrientedTriangle : IndexedTriangle {
  explicit OrientedTriangle(const IndexedTriangle& t)
      : IndexedTriangle(t), first(at[1] - at[0]), second(at[2] - at[0]) {
    normal = cross(first, second);
  }
  Vec3 first, second, normal;
};

// On which sides of a plane the corners of a triangle lie, as far as that is known.
struct PlaneSides {
  std::array<int, 3> sign{};
  std::array<bool, 3> known{};

  bool all_known() const { return known[0] && known[1] && known[2]; }
  bool any(int s) const { return sign[0] == s || sign[1] == s || sign[2] == s; }
  bool both() const { return any(1) && any(-1); }
  bool none() const { return !any(1) && !any(-1); }
};

PlaneSides find_plain_sides(const OrientedTriangle& plane, const IndexedTriangle& t) {
  PlaneSides sides;
  for (int i = 0; i < 3; ++i) {
    if (has_corner(plane.face, t.face[i])) {
      sides.known[i] = true;
      continue;
    }
    const Vec3 way = t.at[i] - plane.at[0];
    sides.sign[i] = sign_beyond(dot(way, plane.normal), error(way, largest(plane.first), largest(plane.second)));
    sides.known[i] = sides.sign[i] != 0;
  }
  return sides;
}

void find_exact_sides(const IndexedTriangle& plane, const IndexedTriangle& t, PlaneSides& sides) {
  for (int i = 0; i < 3; ++i)
    if (!sides.known[i]) sides.sign[i] = -exact::orient3d(plane.at[0], plane.at[1], plane.at[2], t.at[i]);
  sides.known.fill(true);
}

// Whether a plane through a side of f has f on one side and g on the other. It is put up along the rounded normal of
// f, so that this tells neighbors in one plane apart without exact arithmetic.
bool plainly_apart(const OrientedTriangle& f, const IndexedTriangle& g) {
  const double high = largest(f.normal);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const Vec3 p = f.at[i], along = f.at[j] - p, in = cross(f.normal, along);
    const double size = largest(along);
    const auto side = [&](Vec3 x) { return sign_beyond(dot(x - p, in), error(x - p, size, high)); };
    if (side(f.at[k]) <= 0) continue;
    bool out = true;
    for (int l = 0; l < 3 && out; ++l) out = g.face[l] == f.face[i] || g.face[l] == f.face[j] || side(g.at[l]) < 0;
    if (out) return true;
  }
  return false;
}

Point2 drop_axis(Vec3 p, int axis) {
  if (axis == 0) return {p.y, p.z};
  return axis == 1 ? Point2{p.z, p.x} : Point2{p.x, p.y};
}

// Whether some side of f has all of g outside of it; f turns as `turn` tells.
bool apart(const std::array<Point2, 3>& f, const std::array<Point2, 3>& g, int turn) {
  for (int i = 0; i < 3; ++i)
    if (std::all_of(g.begin(), g.end(), [&](Point2 p) { return turn * orient2d(f[i], f[(i + 1) % 3], p) <= 0; }))
      return true;
  return false;
}

bool overlap_in_plane(const IndexedTriangle& f, const IndexedTriangle& g) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto flat = [&](const IndexedTriangle& t) {
      return std::array{drop_axis(t.at[0], axis), drop_axis(t.at[1], axis), drop_axis(t.at[2], axis)};
    };
    const auto p = flat(f), q = flat(g);
    const int turn = orient2d(p[0], p[1], p[2]), other = orient2d(q[0], q[1], q[2]);
    if (turn != 0 && other != 0) return !apart(p, q, turn) && !apart(q, p, other);
  }
  return false;
}

// What a triangle cuts out of the line in which its plane meets another: from the corner that is alone on its side of
// that plane, two sides lead to the ends.
struct LineSpan {
  LineSpan(const IndexedTriangle& t, const PlaneSides& sides) {
    const auto& sign = sides.sign;
    side = std::count(sign.begin(), sign.end(), 1) == 1 ? 1 : -1;
    const int i = sign[0] == side ? 0 : sign[1] == side ? 1 : 2, j = (i + 1) % 3, k = (i + 2) % 3;
    tip = t.at[i];
    first = {t.face[j], t.at[j]};
    last = {t.face[k], t.at[k]};
    if (side < 0) std::swap(first, last);
  }

  struct End {
    Index index;
    Vec3 at;
  };
  int side;
  Vec3 tip;
  End first,
      last;  // the other triangle has its own the other way round, since its normal and this one's change places
};

// Of two triangles that both reach through the other's plane.
bool overlap(const LineSpan& f, const LineSpan& g) {
  // > 0 where the end of f comes before that of g, going from the first end of f to its last.
  const auto order = [&](const LineSpan::End& a, const LineSpan::End& b) {
    return a.index == b.index ? 0 : f.side * g.side * orient3d(f.tip, a.at, g.tip, b.at);
  };
  return order(f.first, g.first) > 0 && order(f.last, g.last) < 0;
}

bool crosses(const OrientedTriangle& f, const IndexedTriangle& other) {
  if (std::all_of(f.face.begin(), f.face.end(), [&](Index p) { return has_corner(other.face, p); })) return false;
  PlaneSides of_g = find_plain_sides(f, other);
  if (of_g.all_known() && !of_g.both() && !of_g.none()) return false;
  const OrientedTriangle g(other);
  PlaneSides of_f = find_plain_sides(g, f);
  if (of_f.all_known() && !of_f.both() && !of_f.none()) return false;
  if (!of_f.all_known() || !of_g.all_known()) {
    if (plainly_apart(f, g) || plainly_apart(g, f)) return false;
    find_exact_sides(f, g, of_g);
    find_exact_sides(g, f, of_f);
  }
  if (of_f.both() && of_g.both()) return overlap(LineSpan(f, of_f), LineSpan(g, of_g));
  return of_f.none() && of_g.none() && overlap_in_plane(f, g);
}

IndexedTriangle index_triangle(const Face& f, Points points) { return {f, corners_of(f, points)}; }

}  // namespace

std::vector<IndexPair> find_crossings(Points points, Faces faces, Flags wanted) {
  if (std::find(wanted.begin(), wanted.end(), 1) == wanted.end()) return {};
  const BoxTree tree(points, faces, list_indices(faces.size()));
  const auto& order = tree.order();
  std::vector<Box> boxes;
  for (const Index f : order) boxes.push_back(box_of(corners_of(faces[f], points)));
  std::vector<std::vector<IndexPair>> found((faces.size() + kBlock - 1) / kBlock);
  parallel_each(
      found.size(),
      [&](Index block) {
        const std::size_t last = std::min((block + 1) * kBlock, faces.size());
        for (auto i = static_cast<Index>(block * kBlock); i < static_cast<Index>(last); ++i) {
          if (!wanted[order[i]]) continue;
          const OrientedTriangle own(index_triangle(faces[order[i]], points));
          tree.visit(boxes[i], [&](Index k) {
            const bool first = k > i || !wanted[order[k]];
            if (first && boxes[k].meets(boxes[i]) && crosses(own, index_triangle(faces[order[k]], points)))
              found[block].push_back({std::min(order[i], order[k]), std::max(order[i], order[k])});
            return true;
          });
        }
      },
      1);
  std::vector<IndexPair> pairs;
  for (const auto& block : found) append(pairs, block);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

CrossingTracker::CrossingTracker(Points points, Faces faces, Faces beside)
    : points_(points), slots_(faces.begin(), faces.end()), own_(static_cast<Index>(faces.size())) {
  append(slots_, beside);
  live_ = slots_.size();
  place_.resize(live_);
  plant(list_indices(live_));
}

IndexedTriangle CrossingTracker::at(Index slot) const { return index_triangle(slots_[slot], points_); }

void CrossingTracker::plant(std::vector<Index> slots) {
  tree_.emplace(points_, slots_, std::move(slots));
  boxes_.clear();
  for (const Index slot : tree_->order()) {
    place_[slot] = static_cast<Index>(boxes_.size());
    boxes_.push_back(box_of(at(slot).at));
  }
}

// Calls leaf(slot, triangle, box) for what stays and has a box that meets this one, until that is false.
template <class Leaf>
bool CrossingTracker::visit(const Box& box, Indices old, Leaf leaf) const {
  return tree_->visit(box, [&](Index place) {
    if (!boxes_[place].meets(box)) return true;
    const Index slot = tree_->order()[place];
    return std::find(old.begin(), old.end(), slot) != old.end() || leaf(slot, at(slot), boxes_[place]);
  });
}

// Some slots, and what crosses them.
class CrossingTracker::EarlierCrossings {
 public:
  EarlierCrossings(const CrossingTracker& mesh, Indices old, Indices around) : mesh_(mesh), old_(old) {
    for (const auto& slots : {old, around})
      for (const Index slot : slots) {
        own_.emplace_back(mesh.at(slot));
        boxes_.push_back(box_of(own_.back().at));
        all_.add(boxes_.back());
      }
  }

  bool each_other() const {
    for (std::size_t i = 0; i < own_.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (crosses(own_[i], own_[j])) return true;
    return false;
  }

  // How many pairs cross of which one at least is old.
  int pairs() const {
    int count = 0;
    Box all;
    for (std::size_t i = 0; i < old_.size(); ++i) {
      all.add(boxes_[i]);
      for (std::size_t j = 0; j < i; ++j) count += crosses(own_[i], own_[j]);
    }
    mesh_.visit(all, old_, [&](Index, const IndexedTriangle& t, const Box& box) {
      for (std::size_t i = 0; i < old_.size(); ++i) count += boxes_[i].meets(box) && crosses(own_[i], t);
      return true;
    });
    return count;
  }

  // Whether a triangle crosses the slots, or another one at its corners does.
  bool at(const IndexedTriangle& t, const Box& box) const {
    if (crossed(t, box)) return true;
    for (int i = 0; i < 3; ++i) {
      Box corner;
      corner.add(t.at[i]);
      const auto other = [&](Index, const IndexedTriangle& g, const Box& own) {
        return !has_corner(g.face, t.face[i]) || !crossed(g, own);
      };
      if (!mesh_.visit(corner, {}, other)) return true;
    }
    return false;
  }

 private:
  bool crossed(const IndexedTriangle& t, const Box& box) const {
    if (!box.meets(all_)) return false;
    for (std::size_t i = 0; i < own_.size(); ++i)
      if (boxes_[i].meets(box) && crosses(own_[i], t)) return true;
    return false;
  }

  const CrossingTracker& mesh_;
  Indices old_;
  std::vector<OrientedTriangle> own_;  // old ones first
  std::vector<Box> boxes_;
  Box all_;
};

bool CrossingTracker::makes_crossing(Indices old, Indices around, std::span<const Change> fresh) const {
  std::vector<OrientedTriangle> come;
  std::vector<Box> boxes;
  Box all;
  for (const auto& [slot, triangle] : fresh) {
    come.emplace_back(triangle);
    boxes.push_back(box_of(triangle.at));
    all.add(boxes.back());
  }
  std::optional<EarlierCrossings> before;
  const auto look_back = [&]() -> EarlierCrossings& { return before ? *before : before.emplace(*this, old, around); };
  int pairs = 0;
  for (std::size_t i = 0; i < come.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) pairs += crosses(come[i], come[j]);
  if (pairs > 0 && !look_back().each_other()) return true;
  const bool moved_on = visit(all, old, [&](Index slot, const IndexedTriangle& t, const Box& box) {
    int own = 0;
    for (std::size_t i = 0; i < come.size(); ++i) own += boxes[i].meets(box) && crosses(come[i], t);
    pairs += own;
    return own == 0 || (slot < own_ && look_back().at(t, box));
  });
  return !moved_on || (pairs > 0 && pairs > look_back().pairs());
}

void CrossingTracker::commit(Indices old, std::span<const Change> fresh) {
  for (const Index slot : old) boxes_[place_[slot]] = {};
  for (const auto& [slot, triangle] : fresh) {
    slots_[slot] = triangle.face;
    boxes_[place_[slot]] = box_of(triangle.at);
    tree_->grow(place_[slot], boxes_[place_[slot]]);
  }
  live_ -= old.size() - fresh.size();
  if (2 * live_ >= boxes_.size()) return;
  std::vector<Index> left;
  for (std::size_t i = 0; i < boxes_.size(); ++i)
    if (boxes_[i].meets(boxes_[i])) left.push_back(tree_->order()[i]);
  plant(std::move(left));
}

}  // namespace bldsimp
