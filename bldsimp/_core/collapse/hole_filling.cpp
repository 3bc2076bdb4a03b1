#include "collapse/hole_filling.hpp"

#include <queue>
#include <tuple>
#include <unordered_map>

#include "mesh/certificate.hpp"
#include "mesh/crossings.hpp"
#include "mesh/edges.hpp"
#include "mesh/errors.hpp"

namespace bldsimp {
namespace {

// Cosine beyond which two faces at an edge lie folded on one another.
constexpr double kFolded = -0.9;

// A corner of what is left to close, as the middle of a face that would cut it off.
struct Ear {
  double length;
  Index middle, stamp;
  bool operator<(const Ear& o) const {  // the shortest is on top of the queue
    return std::tie(o.length, o.middle) < std::tie(length, middle);
  }
};

class HoleFiller {
 public:
  HoleFiller(Points points, Faces faces, double limit);

  // Open halfedges, each loop from the one of its least point on.
  std::vector<std::vector<Index>> loops() const {
    std::vector<std::vector<Index>> found;
    std::vector<bool> seen(open_.size(), false);
    for (std::size_t p = 0; p < open_.size(); ++p) {
      if (open_[p] < 0 || seen[p]) continue;
      std::vector<Index> loop;
      auto at = static_cast<Index>(p);
      while (open_[at] >= 0 && !seen[at]) {
        seen[at] = true;
        loop.push_back(open_[at]);
        at = target(faces_, open_[at]);
      }
      if (at == static_cast<Index>(p)) found.push_back(std::move(loop));
    }
    return found;
  }

  bool close(Indices loop, std::vector<Face>& filling) {
    beside_.clear();
    ears_ = {};
    left_ = loop.size();
    for (const Index h : loop) {
      const Index a = origin(faces_, h), b = target(faces_, h);
      next_[b] = a;
      before_[a] = b;
      beside_[key(a, b)] = normal(faces_[h / 3]);
    }
    for (const Index h : loop) push(origin(faces_, h));
    while (!ears_.empty()) {
      const Ear ear = ears_.top();
      ears_.pop();
      if (stamp_[ear.middle] != ear.stamp || !fits(ear.middle)) continue;
      const Index a = before_[ear.middle], b = next_[ear.middle];
      filling.push_back({a, ear.middle, b});
      if (left_-- == 3) return true;
      ++stamp_[ear.middle];
      next_[a] = b;
      before_[b] = a;
      beside_[key(a, b)] = normal(filling.back());
      edges_[key(a, b)] = 2;
      push(a);
      push(b);
    }
    for (const auto& [a, middle, b] : filling) edges_.erase(key(a, b));
    return false;
  }

 private:
  static std::uint64_t key(Index a, Index b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
  }
  Vec3 normal(const Face& f) const { return area_vector(corners_of(f, points_)); }

  bool folds(const Face& face, Index a, Index b) const {
    const auto beside = beside_.find(key(a, b));
    if (beside == beside_.end()) throw InternalError("fill_holes", "an edge of a loop has no face beside it");
    const Vec3 n = normal(face), m = beside->second;
    return dot(n, m) < kFolded * length(n) * length(m);
  }

  bool fits(Index middle) {
    const Index a = before_[middle], b = next_[middle];
    const Face face{a, middle, b};
    if (folds(face, a, middle) || folds(face, middle, b)) return false;
    if (left_ == 3 ? folds(face, b, a) : edges_.contains(key(a, b))) return false;
    return certificate_.holds(corners_of(face, points_), limit_);
  }

  void push(Index middle) {
    const Vec3 way = points_[next_[middle]] - points_[before_[middle]];
    ears_.push({dot(way, way), middle, ++stamp_[middle]});
  }

  std::vector<Vec3> points_;  // about a local origin
  Faces faces_;
  double limit_;
  FaceTree tree_;
  Certificate certificate_;
  std::vector<Index> open_;                         // open halfedge that starts at each point, -1 none, -2 several
  std::unordered_map<std::uint64_t, Index> edges_;  // between points of open edges: how many faces
  // What is left of the loop that is closed: it runs the other way than the open edges.
  std::vector<Index> next_, before_, stamp_;
  std::unordered_map<std::uint64_t, Vec3> beside_;  // normal of the face at each edge of it
  std::size_t left_ = 0;
  std::priority_queue<Ear> ears_;
};

HoleFiller::HoleFiller(Points points, Faces faces, double limit)
    : points_(about_middle(points)), faces_(faces), limit_(limit), tree_(points_, faces), certificate_(tree_),
      open_(points.size(), -1), next_(points.size(), -1), before_(points.size(), -1), stamp_(points.size(), 0) {
  const auto count = static_cast<Index>(points.size());
  const EdgeBuckets buckets(faces, count);
  std::vector<bool> ends(points.size(), false);
  buckets.visit(0, count, [&](Indices edge) {
    if (edge.size() != 1) return;
    Index& from = open_[origin(faces, edge[0])];
    from = from == -1 ? edge[0] : -2;
    ends[origin(faces, edge[0])] = ends[target(faces, edge[0])] = true;
  });
  for (const Face& f : faces)
    for (int i = 0; i < 3; ++i)
      if (ends[f[i]] && ends[f[(i + 1) % 3]]) ++edges_[key(f[i], f[(i + 1) % 3])];
}

bool has_one_label(Indices loop, Indices label, Flags pinned) {
  return std::all_of(loop.begin(), loop.end(),
                     [&](Index h) { return label[h / 3] == label[loop[0] / 3] && !pinned[h / 3]; });
}

// Which of the fillings' loops stay open, since a face of theirs crosses another one.
std::vector<bool> find_crossing_loops(Points points, Faces faces, Faces fillings, Indices loop, std::size_t loops) {
  std::vector<Face> all(faces.begin(), faces.end());
  append(all, fillings);
  std::vector<std::uint8_t> wanted(all.size(), 0);
  std::fill(wanted.begin() + static_cast<std::ptrdiff_t>(faces.size()), wanted.end(), 1);
  std::vector<bool> stays(loops, false);
  for (const auto& [f, g] : find_crossings(points, all, wanted)) {
    const bool between_lids = static_cast<std::size_t>(f) >= faces.size();
    if (!between_lids || !stays[loop[f - faces.size()]]) stays[loop[g - faces.size()]] = true;
  }
  return stays;
}

}  // namespace

HoleFilling fill_holes(Points points, Faces faces, Indices label, Flags pinned, double limit) {
  HoleFiller closing(points, faces, limit);
  std::vector<Face> made, filling;
  std::vector<Index> loop_of, beside;
  std::size_t loops = 0;
  for (const auto& loop : closing.loops()) {
    filling.clear();
    if (!has_one_label(loop, label, pinned) || !closing.close(loop, filling)) continue;
    for (const Face& face : filling) {
      made.push_back(face);
      loop_of.push_back(static_cast<Index>(loops));
      beside.push_back(loop[0] / 3);
    }
    ++loops;
  }
  const std::vector<bool> stays = find_crossing_loops(points, faces, made, loop_of, loops);
  HoleFilling fillings;
  fillings.closed = static_cast<Index>(std::count(stays.begin(), stays.end(), false));
  for (std::size_t f = 0; f < made.size(); ++f) {
    if (stays[loop_of[f]]) continue;
    fillings.faces.push_back(made[f]);
    fillings.beside.push_back(beside[f]);
  }
  return fillings;
}

}  // namespace bldsimp
