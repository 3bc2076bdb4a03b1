#include "collapse.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <queue>
#include <tuple>
#include <unordered_map>

#include "cover.hpp"
#include "distances.hpp"
#include "edges.hpp"
#include "parallel.hpp"

namespace bldsimp {
namespace {

// Cosine beyond which two faces at an edge lie folded on one another.
constexpr double kFolded = -0.9;
// A face may turn this far at most, as a cosine.
constexpr double kTurned = 0.2;
// A triangle is a needle below this height, as a share of its longest side.
constexpr double kNeedle = 1e-3;
// Weight of an edge's length among costs: of equal ones the shortest goes first.
constexpr double kLength = 1e-6;
// Precision of the final bound, as a share of the tolerance, of which it takes as much away.
constexpr double kPrecision = 5e-3;
constexpr int kMostRounds = 8;

// Sum of squared distances to weighted planes: p A p + 2 b p + c.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0, x = 0, y = 0, z = 0, c = 0;
  void add(Vec3 n, double d, double weight) {
    xx += weight * n.x * n.x, xy += weight * n.x * n.y, xz += weight * n.x * n.z;
    yy += weight * n.y * n.y, yz += weight * n.y * n.z, zz += weight * n.z * n.z;
    x += weight * n.x * d, y += weight * n.y * d, z += weight * n.z * d, c += weight * d * d;
  }
  void add(const Quadric& q) {
    xx += q.xx, xy += q.xy, xz += q.xz, yy += q.yy, yz += q.yz, zz += q.zz;
    x += q.x, y += q.y, z += q.z, c += q.c;
  }
  double at(Vec3 p) const {
    return p.x * (xx * p.x + 2 * (xy * p.y + xz * p.z + x)) + p.y * (yy * p.y + 2 * (yz * p.z + y)) +
           p.z * (zz * p.z + 2 * z) + c;
  }
};

struct Candidate {
  double cost;
  Index from, to, stamp;
  bool operator<(const Candidate& o) const {  // the least is on top of the queue
    return std::tie(o.cost, o.from, o.to) < std::tie(cost, from, to);
  }
};

struct Edge {
  std::array<Index, 2> ends;
  int kind;  // of how many faces: 0 border, 1 other
  std::vector<std::array<Index, 2>> labels;  // of its faces
};

struct HashFace {
  std::size_t operator()(const Face& f) const {
    std::uint64_t h = 0;
    for (const Index i : f) h = (h ^ static_cast<std::uint32_t>(i)) * 0x9e3779b97f4a7c15u, h ^= h >> 29;
    return h;
  }
};

Face sorted(Face f) {
  std::sort(f.begin(), f.end());
  return f;
}

bool has(const Face& f, Index p) { return f[0] == p || f[1] == p || f[2] == p; }

Index third(const Face& f, Index p, Index q) {
  return *std::find_if(f.begin(), f.end(), [&](Index r) { return r != p && r != q; });
}

Face replaced(Face f, Index from, Index to) {
  for (Index& p : f)
    if (p == from) p = to;
  return f;
}

// Faces that are copies of one another but for their winding count as one: {faces, their indices, of the other
// copy or -1}.
struct Single {
  std::vector<Face> faces;
  std::vector<Index> index, copy;
};

Single without_copies(std::span<const Face> faces) {
  std::unordered_map<Face, Index, HashFace> seen;
  seen.reserve(2 * faces.size());
  Single single;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto [at, added] = seen.try_emplace(sorted(faces[f]), static_cast<Index>(single.faces.size()));
    if (added) {
      single.faces.push_back(faces[f]);
      single.index.push_back(static_cast<Index>(f));
      single.copy.push_back(-1);
    } else {
      single.copy[at->second] = static_cast<Index>(f);
    }
  }
  return single;
}

class Collapser {
 public:
  explicit Collapser(const CollapseInput& input);
  Collapsed run();

 private:
  using Refused = std::optional<Refusal>;

  std::array<Vec3, 3> corners(const Face& f) const { return {points_[f[0]], points_[f[1]], points_[f[2]]}; }
  Vec3 normal(const Face& f) const {  // as long as twice the area
    return cross(points_[f[1]] - points_[f[0]], points_[f[2]] - points_[f[0]]);
  }
  std::array<Index, 2> label_of(Index f) const {
    return {input_.label[single_.index[f]], single_.copy[f] < 0 ? -1 : input_.label[single_.copy[f]]};
  }

  void find_borders();
  bool smooth(Index p) const;
  void fix_points();
  void add_quadrics();
  void push_from(Index a);
  void push_all();
  bool pop_all();
  Index edge_between(Index a, Index b) const;
  std::vector<Index> neighbours(Index a) const;

  void survey(Index a, Index b);
  Refused refusal(Index a, Index b);
  bool links() const;
  Refused shape() const;
  bool folds(std::span<const std::pair<Face, bool>> faces) const;
  bool backward();
  bool backward_edge();
  bool forward();
  bool forward_edge();
  void apply();
  double farthest(std::span<const Face> faces, const FaceTree& other) const;
  double deviation(std::span<const Face> result) const;

  CollapseInput input_;
  double limit_;
  std::vector<Vec3> points_;  // about a local origin
  Single single_;
  std::vector<Face>& faces_;
  std::vector<bool> alive_;
  std::vector<std::vector<Index>> star_, rim_;  // faces and border edges at each point
  std::vector<Edge> edges_;
  std::vector<bool> fixed_;
  std::vector<Quadric> quadric_;
  std::vector<Index> stamp_;
  std::priority_queue<Candidate> queue_;
  std::vector<Candidate> refused_;
  std::unordered_map<Face, bool, HashFace> held_;  // answers of the backward test, which never change
  std::array<Index, 2> first_edge_{0, 0};  // of each kind
  std::optional<FaceTree> tree_;
  std::vector<Face> rims_;  // borders of the surface, as faces without area
  std::array<std::optional<FaceTree>, 2> edge_tree_;
  std::optional<Cover> cover_;
  std::array<std::optional<Cover>, 2> edge_cover_;
  Collapsed result_;

  // The collapse that is looked at.
  struct {
    Index a, b, edge, rest;                    // border edge a-b, and the other one at a; -1 for none
    std::vector<Index> dying, moving, around;  // faces; `around` are those that stay as they are, at the ring
    std::vector<Index> old, old_edges, ring, apexes;
  } now_;
};

Collapser::Collapser(const CollapseInput& input)
    : input_(input), limit_((1 - kPrecision) * input.tolerance), single_(without_copies(input.triangles)), faces_(single_.faces) {
  const std::size_t n = input.points.size();
  const Vec3 middle = n ? input.points[n / 2] : Vec3{0, 0, 0};
  points_.reserve(n);
  for (const Vec3& p : input.points) points_.push_back(p - middle);
  alive_.assign(faces_.size(), true);
  star_.resize(n);
  rim_.resize(n);
  fixed_.assign(n, false);
  stamp_.assign(n, 0);
  for (std::size_t f = 0; f < faces_.size(); ++f)
    for (const Index p : faces_[f]) star_[p].push_back(static_cast<Index>(f));
  tree_.emplace(points_, input.surface);
  cover_.emplace(points_, input.surface, faces_, limit_);
  find_borders();
  fix_points();
  add_quadrics();
}

// Edges at which the surface ends or parts, and edges between labels.
std::vector<Edge> borders(std::span<const Face> faces, std::size_t points, auto label) {
  std::vector<Edge> found;
  EdgeBuckets(faces, static_cast<Index>(points)).visit(0, static_cast<Index>(points), [&](std::span<const Index> edge) {
    if (edge.size() == 2 && label(edge[0] / 3) == label(edge[1] / 3)) return;
    found.push_back({{origin(faces, edge[0]), target(faces, edge[0])}, edge.size() == 1 ? 0 : 1, {}});
    for (const Index h : edge) found.back().labels.push_back(label(h / 3));
    std::sort(found.back().labels.begin(), found.back().labels.end());
  });
  return found;
}

std::vector<Face> flat_faces(std::span<const Edge> edges, int kind) {
  std::vector<Face> flat;
  for (const Edge& e : edges)
    if (e.kind == kind) flat.push_back({e.ends[0], e.ends[1], e.ends[1]});
  return flat;
}

void Collapser::find_borders() {
  edges_ = borders(faces_, points_.size(), [&](Index f) { return label_of(f); });
  std::stable_sort(edges_.begin(), edges_.end(), [](const Edge& e, const Edge& f) { return e.kind < f.kind; });
  for (std::size_t e = 0; e < edges_.size(); ++e)
    for (const Index p : edges_[e].ends) rim_[p].push_back(static_cast<Index>(e));
  // Borders of the surface itself; edges between labels are followed as they are now.
  const Single whole = without_copies(input_.surface);
  const auto own = borders(whole.faces, points_.size(), [](Index) { return std::array<Index, 2>{}; });
  for (int kind = 0; kind < 2; ++kind) {
    const auto now = flat_faces(edges_, kind), before = kind == 0 ? flat_faces(own, kind) : now;
    if (kind == 0) first_edge_[1] = static_cast<Index>(now.size());
    if (kind == 0) rims_ = before;
    edge_tree_[kind].emplace(points_, before);
    edge_cover_[kind].emplace(points_, before, now, limit_);
  }
}

// Whether a point lies inside of one sheet or of one chain of borders: the faces around it, each joined to the next
// where no border parts them, are one ring, or all of them lead from one border edge to the other.
bool Collapser::smooth(Index p) const {
  const auto& rim = rim_[p];
  if (!rim.empty() && (rim.size() != 2 || edges_[rim[0]].labels != edges_[rim[1]].labels)) return false;
  std::vector<std::array<Index, 2>> spokes;  // {other end, face}
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
      const auto at = std::lower_bound(spokes.begin(), spokes.end(), std::array<Index, 2>{q, 0});
      f = (*at)[1] == f ? (*(at + 1))[1] : (*at)[1];
    }
  }
  return seen == star_[p].size();
}

// Points stay where chains of borders meet or end, where sheets touch, and where nothing is proven.
void Collapser::fix_points() {
  for (std::size_t p = 0; p < points_.size(); ++p) fixed_[p] = !star_[p].empty() && !smooth(static_cast<Index>(p));
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const bool stays = input_.pinned[single_.index[f]] || (single_.copy[f] >= 0 && input_.pinned[single_.copy[f]]);
    if (stays)
      for (const Index p : faces_[f]) fixed_[p] = true;
  }
  for (const Index f : cover_->unproven())
    for (const Index p : faces_[f]) fixed_[p] = true;
}

void Collapser::add_quadrics() {
  quadric_.resize(points_.size());
  const auto add = [&](Index p, Vec3 n, Vec3 through, double weight) {
    quadric_[p].add(n, -dot(n, through), weight);
  };
  for (const Face& f : faces_) {
    const Vec3 n = normal(f);
    const double twice = length(n);
    if (twice == 0) continue;
    for (const Index p : f) add(p, (1 / twice) * n, points_[f[0]], twice / 6);
  }
  for (const Edge& e : edges_) {
    const auto [a, b] = e.ends;
    const Vec3 along = points_[b] - points_[a];
    for (const Index f : star_[a]) {
      if (!has(faces_[f], b)) continue;
      const Vec3 n = cross(along, normal(faces_[f]));
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

std::vector<Index> Collapser::neighbours(Index a) const {
  std::vector<Index> near;
  for (const Index f : star_[a])
    for (const Index p : faces_[f])
      if (p != a) near.push_back(p);
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  return near;
}

void Collapser::push_from(Index a) {
  ++stamp_[a];
  if (fixed_[a]) return;
  for (const Index b : neighbours(a)) {
    if (!rim_[a].empty() && edge_between(a, b) < 0) continue;
    Quadric sum = quadric_[a];
    sum.add(quadric_[b]);
    const Vec3 way = points_[b] - points_[a];
    const double size = dot(way, way);
    queue_.push({std::max(sum.at(points_[b]), 0.0) + kLength * size * size, a, b, stamp_[a]});
  }
}

void Collapser::push_all() {
  for (std::size_t p = 0; p < points_.size(); ++p)
    if (!star_[p].empty()) push_from(static_cast<Index>(p));
}

void Collapser::survey(Index a, Index b) {
  auto& now = now_;
  now.a = a, now.b = b;
  now.edge = edge_between(a, b);
  now.rest = now.edge < 0 ? -1 : rim_[a][rim_[a][0] == now.edge];
  for (auto* list : {&now.dying, &now.moving, &now.around, &now.old_edges, &now.apexes}) list->clear();
  now.old = star_[a];
  if (now.edge >= 0) now.old_edges = {now.edge, now.rest};
  for (const Index f : star_[a]) {
    if (!has(faces_[f], b)) {
      now.moving.push_back(f);
      continue;
    }
    now.dying.push_back(f);
    for (const Index p : faces_[f])
      if (p != a && p != b) now.apexes.push_back(p);
  }
  std::sort(now.apexes.begin(), now.apexes.end());
  now.ring = neighbours(a);
  for (const Index p : now.ring)
    for (const Index f : star_[p])
      if (!has(faces_[f], a)) now.around.push_back(f);
  std::sort(now.around.begin(), now.around.end());
  now.around.erase(std::unique(now.around.begin(), now.around.end()), now.around.end());
}

// Whether no other points or edges fall together than those of the faces at the edge, which keeps the topology of
// any complex; and no chain of borders falls onto another.
bool Collapser::links() const {
  const auto& now = now_;
  const auto is_apex = [&](Index p) { return std::binary_search(now.apexes.begin(), now.apexes.end(), p); };
  for (const Index p : now.ring) {
    if (p == now.b || is_apex(p)) continue;
    for (const Index f : star_[p])
      if (has(faces_[f], now.b)) return false;
  }
  for (const Index f : now.moving) {
    const Face made = sorted(replaced(faces_[f], now.a, now.b));
    for (const Index g : star_[now.b])
      if (sorted(faces_[g]) == made) return false;
  }
  for (const Index p : now.apexes)
    if (edge_between(now.a, p) >= 0 && edge_between(now.b, p) >= 0) return false;
  if (!now.moving.empty()) return true;
  // An ear goes where its last edge is inside of the surface.
  if (now.dying.size() != 1) return false;
  const Index apex = now.apexes[0];
  return std::count_if(star_[now.b].begin(), star_[now.b].end(),
                       [&](Index f) { return has(faces_[f], apex); }) == 2;
}

// Whether two faces that share an edge lie folded on one another, at least one of them new.
bool Collapser::folds(std::span<const std::pair<Face, bool>> faces) const {
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (!faces[i].second) continue;
    const Face& f = faces[i].first;
    const Vec3 n = normal(f);
    for (std::size_t j = 0; j < faces.size(); ++j) {
      if (j == i || (faces[j].second && j < i)) continue;
      const Face& g = faces[j].first;
      int shared = 0, forward = 0;
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) {
          const Index p = f[k], q = f[(k + 1) % 3], r = g[l], s = g[(l + 1) % 3];
          shared += p == r;
          forward += p == r && q == s;
        }
      if (shared < 2) continue;
      const Vec3 m = normal(g);
      const double cosine = dot(n, m) * (forward ? -1 : 1);
      if (cosine < kFolded * length(n) * length(m)) return true;
    }
  }
  return false;
}

Collapser::Refused Collapser::shape() const {
  const auto& now = now_;
  double least = kNeedle;
  const auto aspect = [&](const Face& f) {
    const double longest = longest_side(corners(f));
    return longest > 0 ? length(normal(f)) / (longest * longest) : 0;
  };
  for (const Index f : now.old) least = std::min(least, aspect(faces_[f]));
  std::vector<std::pair<Face, bool>> before, after;
  for (const Index f : now.moving) {
    const Face made = replaced(faces_[f], now.a, now.b);
    if (aspect(made) < least || aspect(made) == 0) return Refusal::needle;
    const Vec3 n = normal(faces_[f]), m = normal(made);
    const double size = length(n);
    const double longest = longest_side(corners(faces_[f]));
    if (size > limit_ * longest && dot(n, m) < kTurned * size * length(m)) return Refusal::fold;
    after.push_back({made, true});
  }
  for (const Index f : now.around) after.push_back({faces_[f], false});
  if (!folds(after)) return {};
  for (const Index f : now.old) before.push_back({faces_[f], true});
  for (const Index f : now.around) before.push_back({faces_[f], false});
  if (folds(before)) return {};
  return Refusal::fold;
}

bool Collapser::backward() {
  for (const Index f : now_.moving) {
    const Face made = replaced(faces_[f], now_.a, now_.b);
    const auto [entry, added] = held_.try_emplace(sorted(made), false);
    if (added) {
      Index nearest = 0;
      entry->second = tree_->holds(corners(made), limit_, nearest);
    }
    if (!entry->second) return false;
  }
  return true;
}

bool Collapser::backward_edge() {
  if (now_.edge < 0) return true;
  const Edge& rest = edges_[now_.rest];
  const Vec3 p = points_[rest.ends[rest.ends[0] == now_.a]], b = points_[now_.b];
  Index nearest = 0;
  return edge_tree_[rest.kind]->holds({p, b, b}, limit_, nearest);
}

bool Collapser::forward() {
  std::vector<Holder> holders;
  const auto add = [&](Index f, const Face& face) {
    holders.push_back({f, {points_[face[0]], points_[face[1]], points_[face[2]]}});
  };
  for (const Index f : now_.moving) add(f, replaced(faces_[f], now_.a, now_.b));
  for (const Index f : now_.around) {
    if (holders.size() == Cover::most_holders) break;
    add(f, faces_[f]);
  }
  return cover_->finds(now_.old, holders);
}

bool Collapser::forward_edge() {
  if (now_.edge < 0) return true;
  const int kind = edges_[now_.rest].kind;
  const Index first = first_edge_[kind];
  std::vector<Holder> holders;
  const auto add = [&](Index e, Index p, Index q) { holders.push_back({e - first, {points_[p], points_[q], points_[q]}}); };
  const Edge& rest = edges_[now_.rest];
  const Index other = rest.ends[rest.ends[0] == now_.a];
  add(now_.rest, other, now_.b);
  for (const Index p : {other, now_.b})
    for (const Index e : rim_[p])
      if (e != now_.edge && e != now_.rest && edges_[e].kind == kind) add(e, edges_[e].ends[0], edges_[e].ends[1]);
  const std::array<Index, 2> old{now_.edge - first, now_.rest - first};
  return edge_cover_[kind]->finds(old, holders);
}

Collapser::Refused Collapser::refusal(Index a, Index b) {
  survey(a, b);
  if (!links()) return Refusal::link;
  if (const auto bad = shape()) return bad;
  if (!backward_edge()) return Refusal::border;
  if (!backward()) return Refusal::backward;
  if (!forward_edge()) return Refusal::border;
  if (!forward()) return Refusal::forward;
  return {};
}

void Collapser::apply() {
  const auto& now = now_;
  const Index a = now.a, b = now.b;
  cover_->commit(now.old);
  if (now.edge >= 0) {
    const int kind = edges_[now.rest].kind;
    const Index first = first_edge_[kind];
    const std::array<Index, 2> old{now.edge - first, now.rest - first};
    edge_cover_[kind]->commit(old);
    std::erase(rim_[b], now.edge);
    rim_[b].push_back(now.rest);
    for (Index& p : edges_[now.rest].ends)
      if (p == a) p = b;
    rim_[a].clear();
  }
  for (const Index f : now.dying) {
    alive_[f] = false;
    for (const Index p : faces_[f])
      if (p != a) std::erase(star_[p], f);
  }
  for (const Index f : now.moving) {
    faces_[f] = replaced(faces_[f], a, b);
    star_[b].push_back(f);
  }
  star_[a].clear();
  ++stamp_[a];
  quadric_[b].add(quadric_[a]);
  for (const Index p : now.ring) push_from(p);
}

bool Collapser::pop_all() {
  bool any = false;
  while (!queue_.empty()) {
    const Candidate next = queue_.top();
    queue_.pop();
    if (stamp_[next.from] != next.stamp) continue;
    if (const auto why = refusal(next.from, next.to)) {
      ++result_.refusals[static_cast<std::size_t>(*why)];
      continue;
    }
    any = true;
    ++result_.accepted;
    apply();
  }
  return any;
}

// The distances at corners and middles tell how little there is no need to look at closely.
double Collapser::farthest(std::span<const Face> faces, const FaceTree& other) const {
  const double precision = kPrecision / (1 - kPrecision) * limit_;
  std::vector<Vec3> some;
  for (const Face& f : faces) {
    const auto [a, b, c] = corners(f);
    some.insert(some.end(), {a, (1.0 / 3) * (a + b + c)});
  }
  const double least = other.farthest(some, std::numeric_limits<double>::infinity());
  std::vector<double> reach(faces.size());
  parallel_for(
      faces.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) reach[f] = other.reach(corners(faces[f]), least + precision, precision);
      },
      64);
  return reach.empty() ? 0 : *std::max_element(reach.begin(), reach.end());
}

double Collapser::deviation(std::span<const Face> result) const {
  double most = std::max(farthest(input_.surface, FaceTree(points_, result)), farthest(result, *tree_));
  const auto label = [](Index) { return std::array<Index, 2>{}; };
  const auto rim = flat_faces(borders(without_copies(result).faces, points_.size(), label), 0);
  const FaceTree rim_tree(points_, rim);
  // A border that moves is held to the limit; one beyond it closed, or opened, before.
  const auto held = [&](std::span<const Face> edges, const FaceTree& other) {
    std::vector<Face> near;
    std::copy_if(edges.begin(), edges.end(), std::back_inserter(near), [&](const Face& edge) {
      Index nearest = 0;
      return other.holds(corners(edge), limit_, nearest);
    });
    return farthest(near, other);
  };
  return std::max({most, held(rims_, rim_tree), held(rim, *edge_tree_[0])});
}

Collapsed Collapser::run() {
  for (int round = 0; round < kMostRounds; ++round) {
    push_all();
    if (!pop_all()) break;
  }
  std::vector<Index> made(faces_.size(), -1);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (!alive_[f]) continue;
    made[f] = static_cast<Index>(result_.triangles.size());
    result_.triangles.push_back(faces_[f]);
    result_.source.push_back(single_.index[f]);
    if (const Index copy = single_.copy[f]; copy >= 0) {
      result_.triangles.push_back({faces_[f][0], faces_[f][2], faces_[f][1]});
      result_.source.push_back(copy);
    }
  }
  for (std::size_t f = 0; f < input_.surface.size(); ++f)
    result_.holder.push_back(made[cover_->slot_of(static_cast<Index>(f))]);
  if (result_.accepted > 0) result_.deviation = deviation(result_.triangles);
  return std::move(result_);
}

}  // namespace

Collapsed collapse(const CollapseInput& input) { return Collapser(input).run(); }

}  // namespace bldsimp
