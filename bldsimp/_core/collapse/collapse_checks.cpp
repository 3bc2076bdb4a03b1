// Why a collapse or a move is refused.
#include <limits>

#include "collapse/collapser.hpp"
#include "collapse/fans.hpp"

namespace bldsimp {
namespace {

// Cosine beyond which two faces at an edge lie folded on one another.
constexpr double kFolded = -0.9;
// A face may turn this far at most, as a cosine.
constexpr double kTurned = 0.2;
// Cosine from which on a face has not turned.
constexpr double kSame = 0.9999;
// A face must not lean if its area divided by its longest side is over this many tolerances, nor turn away from all of
// the surface from the second on.
constexpr double kWide = 1, kNarrow = 0.5;
// What is farther than the nearest by less than these shares of the tolerance is as near: of walls, of any faces.
constexpr double kAsNear = 0.1, kNear = 0.05;
// Cosine of 30 degrees.
constexpr double kAlike = 0.866;
// A triangle is a needle below this height, as a share of its longest side.
constexpr double kNeedle = 1e-3;
// Corners that are remembered for each point because they did not let it go.
constexpr std::size_t kMostUnheld = 4;

Face replace_corner(Face f, Index from, Index to) {
  for (Index& p : f)
    if (p == from) p = to;
  return f;
}

double aspect(const Triangle& t) {
  const double longest = longest_side(t);
  return longest > 0 ? length(area_vector(t)) / (longest * longest) : 0;
}

// A face at its place, and whether it would be new.
struct FoldFace {
  Face face;
  Vec3 normal;
  bool made;
};

// Whether two faces that share an edge lie folded on one another, at least one of them new.
bool has_fold(std::span<const FoldFace> sides) {
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (!sides[i].made) continue;
    for (std::size_t j = 0; j < sides.size(); ++j) {
      if (j == i || (sides[j].made && j < i)) continue;
      const Face &f = sides[i].face, &g = sides[j].face;
      if (std::count_if(f.begin(), f.end(), [&](Index p) { return has_corner(g, p); }) < 2) continue;
      bool forward = false;
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) forward |= f[k] == g[l] && f[(k + 1) % 3] == g[(l + 1) % 3];
      const double cosine = dot(sides[i].normal, sides[j].normal) * (forward ? -1 : 1);
      if (cosine < kFolded * length(sides[i].normal) * length(sides[j].normal)) return true;
    }
  }
  return false;
}

}  // namespace

void Collapser::survey(Index a, Index b, Vec3 stored) {
  auto& now = now_;
  const Vec3 target = stored - middle_;
  now.a = a, now.b = b, now.target = target, now.stored = stored;
  for (auto* list : {&now.dying, &now.moving, &now.apexes}) list->clear();
  now.made.clear();
  now.old = star_[a];
  for (const Index f : star_[a]) {
    if (b < 0 || !has_corner(faces_[f], b)) {
      now.moving.push_back(f);
      Triangle at = corners(faces_[f]);
      for (int i = 0; i < 3; ++i)
        if (faces_[f][i] == a) at[i] = target;
      now.made.push_back({f, b < 0 ? faces_[f] : replace_corner(faces_[f], a, b), at});
      continue;
    }
    now.dying.push_back(f);
    for (const Index p : faces_[f])
      if (p != a && p != b) now.apexes.push_back(p);
  }
  std::sort(now.apexes.begin(), now.apexes.end());
  find_neighbors(a, now.ring);
  survey_edges();
}

// Most candidates are refused before anything asks for these.
void Collapser::survey_around() {
  now_.around.clear();
  for (const Index p : now_.ring)
    for (const Index f : star_[p])
      if (!has_corner(faces_[f], now_.a)) now_.around.push_back(f);
  sort_unique(now_.around);
}

void Collapser::survey_edges() {
  auto& now = now_;
  now.edge = now.b < 0 ? -1 : edge_between(now.a, now.b);
  now.old_edges.clear();
  now.made_edges.clear();
  if (rim_[now.a].empty()) return;
  now.old_edges = rim_[now.a];
  for (const Index e : now.old_edges) {
    if (e == now.edge) continue;
    const auto& ends = edges_[e].ends;
    now.made_edges.push_back({e, points_[ends[ends[0] == now.a]], now.target});
  }
}

// Whether no other points or edges fall together than those of the faces at the edge, which keeps the topology of
// any complex; and no chain of borders falls onto another.
bool Collapser::links() const {
  const auto& now = now_;
  const auto is_apex = [&](Index p) { return std::binary_search(now.apexes.begin(), now.apexes.end(), p); };
  for (const Index p : now.ring) {
    if (p == now.b || is_apex(p)) continue;
    for (const Index f : star_[p])
      if (has_corner(faces_[f], now.b)) return false;
  }
  for (const NewFace& made : now.made) {
    const Face face = sort_corners(made.face);
    for (const Index g : star_[now.b])
      if (sort_corners(faces_[g]) == face) return false;
  }
  for (const Index p : now.apexes)
    if (edge_between(now.a, p) >= 0 && edge_between(now.b, p) >= 0) return false;
  if (!now.moving.empty()) return true;
  // An ear goes where its last edge is inside of the surface.
  if (now.dying.size() != 1) return false;
  const Index apex = now.apexes[0];
  return std::count_if(star_[now.b].begin(), star_[now.b].end(),
                       [&](Index f) { return has_corner(faces_[f], apex); }) == 2;
}

// Whether a face faces another way than before, and is wide enough, in tolerances, and large enough to be noticed.
bool Collapser::shows_turn(const NewFace& made, double width) const {
  const Vec3 n = area_vector(corners(faces_[made.slot])), m = area_vector(made.corners);
  const double size = length(m);
  return size > 2 * width * limit_ * longest_side(made.corners) &&
         size >= 2 * input_.noticed[distinct_.index[made.slot]] && dot(n, m) < kSame * length(n) * size;
}

// Whether a wide face would lean: a wall is nearest to it, and no wall near it is parallel.
bool Collapser::leans(const NewFace& made) const {
  if (!shows_turn(made, kWide)) return false;
  const auto near = input_.walls.measure_leaning(made.corners, middle_);
  if (!near) return false;
  Index guess = near_[made.slot];
  return *near <= tree_->distance(centroid(made.corners), guess) + kAsNear * limit_;
}

// Whether a face would turn away: none of the nearest faces of the surface is within 30 degrees of it.
bool Collapser::turns(const NewFace& made) const {
  if (!shows_turn(made, kNarrow)) return false;
  const Vec3 middle = centroid(made.corners), m = area_vector(made.corners);
  Index guess = near_[made.slot];
  const double near = tree_->distance(middle, guess) + kNear * limit_;
  return tree_->visit_near(middle, near, [&](Index place) {
    return std::abs(dot(tree_->triangle(place).normal(), m)) < kAlike * length(m);
  });
}

// Whether a face that moves would become a needle or turn too far.
std::optional<Refusal> Collapser::shape() const {
  const auto& now = now_;
  double least = kNeedle;
  for (const Index f : now.old) least = std::min(least, aspect(corners(faces_[f])));
  for (const NewFace& made : now.made) {
    const double own = aspect(made.corners);
    if (own < least || own == 0) return Refusal::needle;
    const Triangle at = corners(faces_[made.slot]);
    const Vec3 n = area_vector(at), m = area_vector(made.corners);
    const double size = length(n);
    if (size > limit_ * longest_side(at) && dot(n, m) < kTurned * size * length(m)) return Refusal::fold;
  }
  return {};
}

// Whether two faces would come to lie folded on one another where none do.
bool Collapser::folds() const {
  std::vector<FoldFace> around, sides;
  around.reserve(now_.around.size());
  for (const Index f : now_.around) around.push_back({faces_[f], area_vector(corners(faces_[f])), false});
  sides.reserve(now_.old.size() + around.size());
  for (const NewFace& made : now_.made) sides.push_back({made.face, area_vector(made.corners), true});
  append(sides, around);
  if (!has_fold(sides)) return false;
  sides.clear();
  for (const Index f : now_.old) sides.push_back({faces_[f], area_vector(corners(faces_[f])), true});
  append(sides, around);
  return !has_fold(sides);
}

// How far what is made is from the surface, by what is known of what it replaces.
void Collapser::bound() {
  auto& now = now_;
  now.far = std::numeric_limits<double>::infinity();
  if (!rim_[now.a].empty()) return;
  double far = 0;
  for (const Index f : now.old) far = std::max(far, far_[f]);
  if (!(far < limit_)) return;
  std::vector<std::array<Vec3, 2>> ring;
  for (const Index f : now.old) {
    const auto i = static_cast<std::size_t>(std::find(faces_[f].begin(), faces_[f].end(), now.a) - faces_[f].begin());
    ring.push_back({points_[faces_[f][(i + 1) % 3]], points_[faces_[f][(i + 2) % 3]]});
  }
  now.far = far + bound_fan_distance(points_[now.a], now.target, ring);
}

// A few places tell of most faces that are too far, and soon.
bool Collapser::backward_at_places() {
  for (const NewFace& made : now_.made) {
    if (!tree_->within(centroid(made.corners), limit_, near_[made.slot])) return false;
  }
  Index near = now_.made.empty() ? 0 : near_[now_.made[0].slot];
  return std::all_of(now_.ring.begin(), now_.ring.end(), [&](Index p) {
    return p == now_.b || tree_->within(0.5 * (points_[p] + now_.target), limit_, near);
  });
}

bool Collapser::backward() {
  return std::all_of(now_.made.begin(), now_.made.end(),
                     [&](const NewFace& made) { return certificate_->holds(made.corners, limit_, near_[made.slot]); });
}

bool Collapser::backward_edge() {
  return std::all_of(now_.made_edges.begin(), now_.made_edges.end(), [&](const NewEdge& made) {
    return edge_certificate_[edges_[made.edge].kind]->holds({made.begin, made.end, made.end}, limit_);
  });
}

void Collapser::gather_holders() {
  auto& holders = now_.holders;
  holders.clear();
  for (const auto& [slot, face, at] : now_.made) holders.push_back({slot, {at[0], at[1], at[2]}});
  for (const Index f : now_.around) {
    if (holders.size() >= ContainmentProof::most_holders) break;
    const auto [a, b, c] = corners(faces_[f]);
    holders.push_back({f, {a, b, c}});
  }
}

// Most refusals repeat earlier ones: what did not let a point go then mostly does not now, whichever way it goes.
bool Collapser::stays_unheld() {
  const auto& corners = unheld_[now_.a];
  return std::any_of(corners.begin(), corners.end(), [&](const ContainmentProof::UnheldCorner& corner) {
    return containment_->stays_unheld(corner, now_.old, now_.holders);
  });
}

bool Collapser::forward() {
  if (containment_->finds(now_.old, now_.holders)) return true;
  if (containment_->unheld().piece < 0) return false;
  auto& corners = unheld_[now_.a];
  if (corners.size() == kMostUnheld) corners.erase(corners.begin());
  corners.push_back(containment_->unheld());
  return false;
}

bool Collapser::forward_edge() {
  auto& holders = now_.edge_holders;
  holders.clear();
  if (now_.old_edges.empty()) return true;
  const int kind = edges_[now_.old_edges[0]].kind;
  const Index first = first_edge_[kind];
  std::vector<Index> old(now_.old_edges), beside;
  for (const auto& [e, p, q] : now_.made_edges) holders.push_back({e - first, {p, q, q}});
  for (const Index e : now_.old_edges)
    for (const Index p : edges_[e].ends)
      if (p != now_.a) beside.insert(beside.end(), rim_[p].begin(), rim_[p].end());
  for (const Index e : beside) {
    if (edges_[e].kind != kind || std::find(old.begin(), old.end(), e) != old.end()) continue;
    const auto [p, q] = edges_[e].ends;
    if (input_.shared[p] && input_.shared[q]) continue;
    holders.push_back({e - first, {points_[p], points_[q], points_[q]}});
  }
  for (Index& e : old) e -= first;
  return edge_containment_[kind]->finds(old, holders);
}

std::optional<Refusal> Collapser::find_refusal() {
  if (now_.b >= 0 && !links()) return Refusal::link;
  if (const auto bad = shape()) return bad;
  survey_around();
  if (folds() || std::ranges::any_of(now_.made, [&](const NewFace& made) { return leans(made); })) return Refusal::fold;
  gather_holders();
  if (stays_unheld()) return Refusal::forward;
  if (!backward_edge()) return Refusal::border;
  bound();
  const bool known = now_.far <= limit_;
  if (!known && !backward_at_places()) return Refusal::backward;
  if (!forward_edge()) return Refusal::border;
  if (crossings_->makes_crossing(now_.old, now_.around, changes())) return Refusal::crossing;
  if (!forward()) return Refusal::forward;
  if (!known && !backward()) return Refusal::backward;
  if (std::ranges::any_of(now_.made, [&](const NewFace& made) { return turns(made); })) return Refusal::fold;
  if (!known) now_.far = limit_;
  return {};
}

std::vector<CrossingTracker::Change> Collapser::changes() const {
  std::vector<CrossingTracker::Change> changes;
  for (const NewFace& made : now_.made) {
    Triangle at;
    for (int i = 0; i < 3; ++i) {
      const Index p = made.face[i];
      at[i] = p == (now_.b < 0 ? now_.a : now_.b) ? now_.stored : result_.points[p];
    }
    changes.push_back({made.slot, {made.face, at}});
  }
  return changes;
}

}  // namespace bldsimp
