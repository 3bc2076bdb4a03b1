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
// A triangle is a needle below this height, as a share of its longest side.
constexpr double kNeedle = 1e-3;

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
      int shared = 0, forward = 0;
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) {
          const Index p = sides[i].face[k], q = sides[i].face[(k + 1) % 3];
          const Index r = sides[j].face[l], t = sides[j].face[(l + 1) % 3];
          shared += p == r;
          forward += p == r && q == t;
        }
      if (shared < 2) continue;
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
  for (auto* list : {&now.dying, &now.moving, &now.around, &now.apexes}) list->clear();
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
  now.ring = neighbors(a);
  for (const Index p : now.ring)
    for (const Index f : star_[p])
      if (!has_corner(faces_[f], a)) now.around.push_back(f);
  sort_unique(now.around);
  survey_edges();
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

std::optional<Refusal> Collapser::shape() const {
  const auto& now = now_;
  double least = kNeedle;
  std::vector<FoldFace> before, after;
  for (const Index f : now.old) {
    const Triangle at = corners(faces_[f]);
    least = std::min(least, aspect(at));
    before.push_back({faces_[f], area_vector(at), true});
  }
  for (const NewFace& made : now.made) {
    const double own = aspect(made.corners);
    if (own < least || own == 0) return Refusal::needle;
    const Triangle at = corners(faces_[made.slot]);
    const Vec3 n = area_vector(at), m = area_vector(made.corners);
    const double size = length(n);
    if (size > limit_ * longest_side(at) && dot(n, m) < kTurned * size * length(m)) return Refusal::fold;
    after.push_back({made.face, m, true});
  }
  for (const Index f : now.around) {
    before.push_back({faces_[f], area_vector(corners(faces_[f])), false});
    after.push_back(before.back());
  }
  if (has_fold(after) && !has_fold(before)) return Refusal::fold;
  return {};
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

bool Collapser::forward() {
  auto& holders = now_.holders;
  holders.clear();
  for (const auto& [slot, face, at] : now_.made) holders.push_back({slot, {at[0], at[1], at[2]}});
  for (const Index f : now_.around) {
    if (holders.size() >= ContainmentProof::most_holders) break;
    const auto [a, b, c] = corners(faces_[f]);
    holders.push_back({f, {a, b, c}});
  }
  return containment_->finds(now_.old, holders);
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
  if (!backward_edge()) return Refusal::border;
  bound();
  const bool known = now_.far <= limit_;
  if (!known && !backward_at_places()) return Refusal::backward;
  if (!forward_edge()) return Refusal::border;
  if (crossings_->makes_crossing(now_.old, now_.around, changes())) return Refusal::crossing;
  if (!forward()) return Refusal::forward;
  if (!known && !backward()) return Refusal::backward;
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
