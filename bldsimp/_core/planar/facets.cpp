#include "planar/facets.hpp"

#include <atomic>
#include <limits>
#include <queue>
#include <tuple>

#include "mesh/box_tree.hpp"
#include "mesh/edges.hpp"
#include "mesh/index_sets.hpp"
#include "mesh/parallel.hpp"
#include "mesh/plane_fit.hpp"
#include "mesh/predicates.hpp"

namespace bldsimp {
namespace {

// The slab between two parallel planes that holds some points.
struct Slab {
  Vec3 normal{0, 0, 0};
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double height) {
    low = std::min(low, height);
    high = std::max(high, height);
  }
  double width() const { return high - low; }
};

class FacetFinder {
 public:
  FacetFinder(Points points, Faces faces, Indices twin, Indices label, Vec3 origin, const FacetLimits& limits)
      : points_(points), faces_(faces), twin_(twin), label_(label), origin_(origin), limits_(limits) {
    facet_of_face_.assign(faces.size(), -1);
    find_needles();
  }

  Facets find() {
    candidate_ = join_across(twin_, [&](Index h, Index t) { return flat_across(h, t); });
    accept_or_grow();
    return number_by_first_face();
  }

 private:
  Vec3 corner(Index f, int i) const { return points_[faces_[f][i]]; }
  Vec3 area_vector(Index f) const { return area_vector_[f]; }
  double height_in(Vec3 normal, Vec3 p) const { return dot(normal, p - origin_); }

  void find_needles() {
    longest_.resize(faces_.size());
    area_vector_.resize(faces_.size());
    parallel_each(faces_.size(), [&](Index f) { measure_face(f); });
  }

  void measure_face(Index f) {
    const Vec3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
    const auto squared = [](Vec3 d) { return dot(d, d); };
    const double ab = squared(b - a), bc = squared(c - b), ca = squared(a - c);
    const double longest = std::max({ab, bc, ca});
    const Vec3 n = cross(b - a, c - a);
    const bool needle = squared(n) <= limits_.needle * limits_.needle * longest;
    area_vector_[f] = n;
    longest_[f] = static_cast<std::int8_t>((ab == longest ? 0 : bc == longest ? 1 : 2) | (needle ? needle_bit : 0));
  }
  bool is_needle(Index f) const { return (longest_[f] & needle_bit) != 0; }
  Index longest_halfedge(Index f) const { return 3 * f + (longest_[f] & 3); }

  // The face whose plane stands for that of f: f itself, or for a needle the face that is reached across
  // longest edges; where that leads nowhere, f has to do.
  Index host(Index f) const {
    Index at = f;
    for (int steps = 0; steps < 16; ++steps) {
      if (!is_needle(at)) return at;
      const Index t = twin_[longest_halfedge(at)];
      if (t < 0 || label_[t / 3] != label_[f]) return f;
      at = t / 3;
    }
    return f;
  }

  double height(Index f) const {
    const Index h = longest_halfedge(f);
    return length(area_vector(f)) / length(points_[target(faces_, h)] - points_[origin(faces_, h)]);
  }

  // How far a needle reaches out of its host: each face on the way lies within its height of the next one's
  // edge. Infinite where there is no host, or the host is not in the same set.
  double fold_of(Index f) const {
    constexpr double nowhere = std::numeric_limits<double>::infinity();
    const Index base = host(f);
    if (is_needle(base) || candidate_[base] != candidate_[f] || facet_of_face_[base] != facet_of_face_[f])
      return nowhere;
    return fold_from(f, base);
  }

  double fold_from(Index f, Index base) const {
    double fold = 0;
    for (Index at = f; at != base; at = twin_[longest_halfedge(at)] / 3) fold += height(at);
    return fold;
  }

  // The greatest fold of the faces that are turned over in a plane: what they cover, others may not. A guess that
  // keeps what folds too far out of a facet; how far it does is measured on the result.
  double greatest_fold(Indices set, Vec3 normal) const {
    if (normal == Vec3{0, 0, 0}) return 0;
    double fold = 0;
    for (const Index f : set)
      if (is_needle(f) && dot(area_vector(f), normal) <= 0) fold = std::max(fold, fold_of(f));
    return fold;
  }

  // Whether all three points of g lie within the width of the plane of f, facing the same way.
  bool in_plane_of(Index f, Index g) const {
    const Vec3 n = area_vector(f), a = corner(f, 0);
    if (dot(n, area_vector(g)) <= 0) return false;
    for (int i = 0; i < 3; ++i) {
      if (limits_.width > 0) {
        if (std::abs(dot(n, corner(g, i) - a)) > limits_.width * length(n)) return false;
      } else if (orient3d(a, corner(f, 1), corner(f, 2), corner(g, i)) != 0) {
        return false;
      }
    }
    return true;
  }

  // The same for two faces that share the edge of h and t, where only the third points are in question.
  // The larger face has the more reliable plane.
  bool in_plane(Index h, Index t) const {
    const Vec3 n = area_vector(h / 3), m = area_vector(t / 3);
    if (dot(n, m) <= 0) return false;
    if (limits_.width == 0) return in_plane_of(h / 3, t / 3);
    const double nn = dot(n, n), mm = dot(m, m);
    const Index larger = nn >= mm ? h : t, smaller = nn >= mm ? t : h;
    const double height = dot(area_vector(larger / 3), points_[apex(faces_, smaller)] - points_[origin(faces_, h)]);
    return height * height <= limits_.width * limits_.width * std::max(nn, mm);
  }

  bool flat_across(Index h, Index t) const {
    const Index f = h / 3, g = t / 3;
    if (label_[f] != label_[g] || label_[f] < 0) return false;
    if ((is_needle(f) && h == longest_halfedge(f)) || (is_needle(g) && t == longest_halfedge(g))) return true;
    if (!is_needle(f) && !is_needle(g)) return in_plane(h, t);
    const Index a = host(f), b = host(g);
    const Vec3 n = area_vector(a), m = area_vector(b);
    return dot(n, n) >= dot(m, m) ? in_plane_of(a, b) : in_plane_of(b, a);
  }

  void accept_or_grow() {
    const Groups sets(faces_.size(), faces_.size(), [&](Index f) { return candidate_[f]; });
    std::vector<Index> roots;
    for (Index f = 0; f < std::ssize(candidate_); ++f)
      if (candidate_[f] == f) roots.push_back(f);
    std::vector<Slab> slabs(roots.size());
    std::vector<std::uint8_t> accepted(roots.size());
    // Sets differ in size: the threads take them one by one.
    std::atomic<std::size_t> next = 0;
    const auto test_sets = [&](std::size_t, std::size_t) {
      for (std::size_t i = next++; i < roots.size(); i = next++) {
        slabs[i] = fit(sets[roots[i]]);
        // At zero tolerance exact coplanarity passes from face to face: the union needs no fit.
        accepted[i] =
            (limits_.width == 0 || slabs[i].width() <= limits_.width) && all_face(sets[roots[i]], slabs[i].normal);
      }
    };
    parallel_for(faces_.size(), test_sets);
    for (std::size_t i = 0; i < roots.size(); ++i) {
      if (accepted[i])
        add_facet(sets[roots[i]], slabs[i]);
      else
        grow_within(sets[roots[i]]);
      curved_.resize(planes_.size(), !accepted[i]);
    }
  }

  // A plane of the faces and the slab about it; no normal where they are no wider than a needle. The sum of
  // the area vectors depends on the outline alone, and is good enough for most facets; where its slab is too
  // wide, the best fit decides.
  Slab fit(Indices set) const {
    Slab slab;
    Vec3 facing{0, 0, 0};
    bool has_plane = false;
    for (const Index f : set) {
      facing = facing + area_vector(f);
      has_plane |= !is_needle(f);
    }
    if (has_plane || is_wider_than_needle(set)) slab.normal = normalize(facing);
    slab = measure(slab, set);
    if (slab.width() <= limits_.width || set.size() == 1) return slab;
    Moments moments(corner(set[0], 0));
    for (const Index f : set) moments.add(corner(f, 0), corner(f, 1), corner(f, 2));
    Slab best;
    best.normal = moments.normal();
    if (dot(best.normal, facing) < 0) best.normal = -1.0 * best.normal;
    best = measure(best, set);
    return best.width() < slab.width() ? best : slab;
  }

  bool is_wider_than_needle(Indices set) const {
    double area = 0;
    Box box;
    for (const Index f : set) {
      area += length(area_vector(f));
      for (const Index p : faces_[f]) box.add(points_[p]);
    }
    return area > limits_.needle * length(box.high - box.low);
  }

  Slab measure(Slab slab, Indices set) const {
    for (const Index f : set)
      for (int i = 0; i < 3; ++i) slab.add(height_in(slab.normal, corner(f, i)));
    return slab;
  }

  // Whether no face is turned over in the plane, but for needles that stay close to the others.
  bool all_face(Indices set, Vec3 normal) const {
    return std::all_of(set.begin(), set.end(),
                       [&](Index f) { return is_needle(f) || dot(area_vector(f), normal) > 0; }) &&
           greatest_fold(set, normal) <= limits_.fold;
  }

  void add_facet(Indices set, const Slab& slab) {
    for (const Index f : set) facet_of_face_[f] = static_cast<Index>(planes_.size());
    planes_.push_back({slab.normal, slab.low, slab.high});
  }

  // Grows facets inside a candidate that is not flat as a whole (a drifting or stepped surface), from
  // the largest face on, since a large face has the most reliable plane.
  void grow_within(Indices set) {
    std::vector<std::pair<double, Index>> seeds;
    for (const Index f : set) {
      const Vec3 n = area_vector(f);
      seeds.push_back({is_needle(f) ? -1.0 : dot(n, n), f});
    }
    std::sort(seeds.begin(), seeds.end(), [](const auto& a, const auto& b) {
      return a.first != b.first ? a.first > b.first : a.second < b.second;
    });
    const Index first = static_cast<Index>(planes_.size());
    for (const auto& [area, f] : seeds)
      if (facet_of_face_[f] < 0) grow_from(f);
    merge_grown(set, first);
  }

  // Growth takes faces as they come; whole facets that fit one slab together are joined afterwards,
  // the narrowest slab first. (On a curved part this saves some 2 % of the points.)
  void merge_grown(Indices set, Index first) {
    const std::size_t count = planes_.size() - first;
    if (count < 2) return;
    std::vector<std::vector<Index>> members(count), beside(count);
    for (const Index f : set) {
      const Index a = facet_of_face_[f] - first;
      members[a].push_back(f);
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        const Index g = twin_[h] / 3;
        if (twin_[h] >= 0 && candidate_[g] == candidate_[f]) beside[a].push_back(facet_of_face_[g] - first);
      }
    }
    struct Merge {
      double width;
      Index a, b;
      std::size_t size_a, size_b;  // a merge is out of date when either has grown since
      bool operator<(const Merge& m) const { return std::tie(m.width, m.a, m.b) < std::tie(width, a, b); }
    };
    std::priority_queue<Merge> queue;
    std::vector<Index> both;
    const auto propose = [&](Index a, Index b) {
      const Plane& plane = planes_[first + (members[a].size() >= members[b].size() ? a : b)];
      Slab slab{plane.normal, plane.low, plane.high};
      // A fit can at best halve what the points of one stray from the plane of the other.
      for (const Index f : members[a].size() >= members[b].size() ? members[b] : members[a])
        if (!fits(slab, f, 2 * limits_.width)) return;
      both = members[a];
      append(both, members[b]);
      const Slab joint = fit(both);
      if (joint.width() <= limits_.width && all_face(both, joint.normal))
        queue.push({joint.width(), a, b, members[a].size(), members[b].size()});
    };
    const auto tidy = [&](Index a) {
      sort_unique(beside[a]);
      std::erase_if(beside[a], [&](Index b) { return b == a || members[b].empty(); });
    };
    for (Index a = 0; a < static_cast<Index>(count); ++a) {
      tidy(a);
      for (const Index b : beside[a])
        if (a < b) propose(a, b);
    }
    while (!queue.empty()) {
      const Merge merge = queue.top();
      queue.pop();
      const auto [width, a, b, size_a, size_b] = merge;
      if (members[a].size() != size_a || members[b].size() != size_b) continue;
      append(members[a], members[b]);
      std::sort(members[a].begin(), members[a].end());
      members[b].clear();
      for (const Index f : members[a]) facet_of_face_[f] = first + a;
      const Slab slab = fit(members[a]);
      planes_[first + a] = {slab.normal, slab.low, slab.high};
      append(beside[a], beside[b]);
      for (const Index c : beside[b]) beside[c].push_back(a);
      tidy(a);
      for (const Index c : beside[a]) propose(std::min(a, c), std::max(a, c));
    }
  }

  void grow_from(Index seed) {
    const Index facet = static_cast<Index>(planes_.size());
    region_.assign(1, seed);
    facet_of_face_[seed] = facet;
    Slab slab = fit(region_);
    std::size_t next_fit = 2;
    for (std::size_t front = 0, fitted = 0; fitted != region_.size();) {
      fitted = region_.size();
      for (front = 0; front < region_.size(); ++front) {
        for (int i = 0; i < 3; ++i) {
          const Index h = 3 * region_[front] + i, t = twin_[h];
          if (t < 0 || facet_of_face_[t / 3] >= 0 || !may_join(slab, h, t)) continue;
          facet_of_face_[t / 3] = facet;
          region_.push_back(t / 3);
          for (int k = 0; k < 3; ++k) slab.add(height_in(slab.normal, corner(t / 3, k)));
          if (region_.size() == next_fit) {
            refit(slab);
            next_fit *= 2;
          }
        }
      }
      // A better plane may reach farther: sweep the region again until it stays as it is.
      if (fitted != region_.size()) refit(slab);
    }
    planes_.push_back({slab.normal, slab.low, slab.high});
  }

  bool may_join(const Slab& slab, Index h, Index t) const {
    const Index f = h / 3, g = t / 3;
    if (candidate_[f] != candidate_[g]) return false;
    if (!fits(slab, g, limits_.width)) return false;
    if (!is_needle(g)) return dot(area_vector(g), slab.normal) > 0;
    if (dot(area_vector(g), slab.normal) > 0) return true;
    const Index base = host(g);
    return t == longest_halfedge(g) && facet_of_face_[base] == facet_of_face_[f] && fold_from(g, base) <= limits_.fold;
  }

  // Whether the slab stays narrow enough with the points of f.
  bool fits(Slab slab, Index f, double width) const {
    for (int k = 0; k < 3; ++k) slab.add(height_in(slab.normal, corner(f, k)));
    return slab.width() <= width;
  }

  void refit(Slab& slab) const {
    const Slab better = fit(region_);
    if (better.width() <= limits_.width && all_face(region_, better.normal)) slab = better;
  }

  Facets number_by_first_face() const {
    Facets facets;
    facets.facet_of_face.resize(faces_.size());
    std::vector<Index> number(planes_.size(), -1);
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      Index& n = number[facet_of_face_[f]];
      if (n < 0) {
        n = static_cast<Index>(facets.planes.size());
        facets.planes.push_back(planes_[facet_of_face_[f]]);
        facets.curved.push_back(curved_[facet_of_face_[f]]);
      }
      facets.facet_of_face[f] = n;
    }
    return facets;
  }

  static constexpr std::int8_t needle_bit = 4;

  Points points_;
  Faces faces_;
  Indices twin_;
  Indices label_;
  Vec3 origin_;
  FacetLimits limits_;
  Array<Vec3> area_vector_;     // per face, twice its area long
  Array<std::int8_t> longest_;  // corner at which the longest edge starts, and needle_bit
  Array<Index> candidate_;      // per face the least face of its candidate
  Array<Index> facet_of_face_;
  std::vector<Plane> planes_;
  std::vector<std::uint8_t> curved_;  // per plane
  std::vector<Index> region_;
};

}  // namespace

Facets find_facets(Points points, Faces faces, const Halfedges& halfedges, Indices label, Vec3 origin,
                   const FacetLimits& limits) {
  return FacetFinder(points, faces, halfedges.twin, label, origin, limits).find();
}

Facets split_off(const Facets& facets, Indices cut) {
  Facets result = facets;
  for (const Index f : cut) {
    result.planes.push_back(facets.planes[facets.facet_of_face[f]]);
    result.facet_of_face[f] = static_cast<Index>(result.planes.size()) - 1;
  }
  return result;
}

Groups group_faces(const Facets& facets) {
  return {facets.planes.size(), facets.facet_of_face.size(), [&](Index f) { return facets.facet_of_face[f]; }};
}

}  // namespace bldsimp
