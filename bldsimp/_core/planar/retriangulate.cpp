#include "planar/retriangulate.hpp"

#include "cdt/cdt.hpp"
#include "mesh/certificate.hpp"
#include "mesh/double_word.hpp"
#include "mesh/parallel.hpp"
#include "planar/facet_chains.hpp"
#include "planar/projection.hpp"

namespace bldsimp {
namespace {

// Along an edge between two faces no part of a triangle that lies over both is nearer to one than its height.
double height(const Triangle& triangle) {
  const auto& [a, b, c] = triangle;
  const double longest = std::max({length(b - a), length(c - b), length(a - c)});
  return longest > 0 ? length(cross(b - a, c - a)) / longest : 0;
}

class Retriangulator {
 public:
  Retriangulator(const FacetParts& parts, const FacetChains& chains)
      : parts_(parts), chains_(chains), facet_of_point_(parts.points.size(), -1) {}

  void run(Index facet, bool keep, Patches& patches) {
    if (keep || nothing_dropped(facet)) {
      for (const Index f : faces_of(facet)) emit(facet, parts_.faces[f], patches);
      patches.outcomes.push_back(Outcome::unchanged);
      patches.reach.push_back(0);
      return;
    }
    collect_segments(facet);
    patches.reach.push_back(0);
    patches.outcomes.push_back(triangulate(facet, patches));
  }

 private:
  Indices faces_of(Index facet) const {
    return {parts_.face_order.data() + parts_.face_start[facet],
            parts_.face_order.data() + parts_.face_start[facet + 1]};
  }

  bool nothing_dropped(Index facet) const {
    for (const Index f : faces_of(facet))
      for (const Index p : parts_.faces[f])
        if (!parts_.kept[p]) return false;
    return true;
  }

  static void emit(Index facet, const Face& triangle, Patches& patches) {
    patches.triangles.push_back(triangle);
    patches.facet_of_triangle.push_back(facet);
  }

  void collect_segments(Index facet) {
    local_.begin(parts_.outlines, facet);
    piece_of_segment_.clear();
    chains_.for_pieces(facet, [&](Index i, bool forward) {
      local_.add_segment(parts_.pieces[i].from, parts_.pieces[i].to, forward);
      piece_of_segment_.push_back(i);
    });
    local_.end(parts_.outlines, facet);
  }

  // A facet whose pieces all lie on one another has vanished from both sides. One without an outline is
  // a component by itself, closed and without a plane, and there is no neighbor to close up in its place.
  bool has_vanished() const { return !local_.segments.empty() && find_unopposed(local_.segments).empty(); }

  Outcome triangulate(Index facet, Patches& patches) {
    if (has_vanished())
      return euler_agrees(facet, 0) && needles_stay_close(facet, {}, patches) ? Outcome::done : Outcome::mismatch;
    const Plane& plane = parts_.planes[front_of(parts_.outlines, facet)];
    if (plane.normal == Vec3{0, 0, 0} || local_.segments.empty()) return Outcome::mismatch;
    const Projection projection = local_.project(parts_.points, plane.normal);
    TriangulateOptions options;
    options.lift = local_.lift.data();
    const Status status = triangulator_.run(local_.flat, local_.segments, options);
    patches.statistics += triangulator_.statistics();
    if (status != Status::done) {
      for (const Index s : triangulator_.crossing()) {
        put_back(facet, s, patches);
        note_trouble(facet, local_.segments[s][0], local_.segments[s][1], patches);
      }
      return Outcome::crossing;
    }
    if (find_touching(facet, patches)) return Outcome::crossing;
    if (!euler_agrees(facet, triangulator_.triangles().size()) || !area_agrees(facet, projection) ||
        !needles_stay_close(facet, triangulator_.triangles(), patches))
      return Outcome::mismatch;
    for (const auto& t : triangulator_.triangles()) emit(facet, local_.to_mesh(t), patches);
    return Outcome::done;
  }

  void put_back(Index facet, Index segment, Patches& patches) const {
    const Index farthest = parts_.pieces[piece_of_segment_[segment]].farthest;
    if (farthest >= 0) patches.put_back.push_back({facet, farthest});
  }

  void note_trouble(Index facet, Index a, Index b, Patches& patches) const {
    note_edge(facet, local_.points[a], local_.points[b], patches);
  }
  static void note_edge(Index facet, Index a, Index b, Patches& patches) {
    patches.trouble.push_back({facet, std::min(a, b), std::max(a, b)});
  }

  // A piece that was split has a point of the outline on it: its neighbor would not know of it.
  bool find_touching(Index facet, Patches& patches) {
    bool touching = false;
    for (const auto& [a, b, segment] : triangulator_.pieces()) {
      const auto& ends = local_.segments[segment];
      if (std::minmax(a, b) == std::minmax(ends[0], ends[1])) continue;
      touching = true;
      put_back(facet, segment, patches);
      note_trouble(facet, ends[0], ends[1], patches);
      for (const Index end : {a, b})
        if (end != ends[0] && end != ends[1]) note_trouble(facet, end, end, patches);
      for (Index s = 0; s < static_cast<Index>(local_.segments.size()); ++s)
        for (const Index end : local_.segments[s])
          if ((end == a || end == b) && end != ends[0] && end != ends[1]) put_back(facet, s, patches);
    }
    return touching;
  }

  // Whether the facet has the Euler characteristic that it had. With that its rings bound as many pieces
  // as before: a ring that is turned over in the projection, or a neck that closes, would make pieces of
  // their own. Where two of its borders were laid on one another it has changed, rightly.
  bool euler_agrees(Index facet, std::size_t triangles) {
    std::int64_t points = 0, rim_before = 0, rim_after = 0;
    for (const Index f : faces_of(facet))
      for (const Index p : parts_.faces[f])
        if (facet_of_point_[p] != facet) {
          facet_of_point_[p] = facet;
          ++points;
        }
    for (Index u = chains_.use_start[facet]; u < chains_.use_start[facet + 1]; ++u) {
      const Index chain = chains_.chain_uses[u].first;
      if (runs_on_both_sides(facet, u)) continue;
      rim_before += parts_.outlines.chain_start[chain + 1] - parts_.outlines.chain_start[chain] - 1;
      rim_after += chains_.piece_start[chain + 1] - chains_.piece_start[chain];
    }
    if (std::ssize(find_unopposed(local_.segments)) < rim_after) return true;
    // Points - edges + triangles, where 2 edges = 3 triangles + edges of the rim; twice.
    const auto twice_euler = [](std::int64_t p, std::int64_t t, std::int64_t rim) { return 2 * p - t - rim; };
    return twice_euler(points, std::ssize(faces_of(facet)), rim_before) ==
           twice_euler(std::ssize(local_.points), static_cast<std::int64_t>(triangles), rim_after);
  }

  // A slit: the facet lies on both sides of a chain. Its two uses of that chain stand side by side.
  bool runs_on_both_sides(Index facet, Index u) const {
    const auto same_chain = [&](Index v) {
      return v >= chains_.use_start[facet] && v < chains_.use_start[facet + 1] &&
             chains_.chain_uses[v].first == chains_.chain_uses[u].first;
    };
    return same_chain(u - 1) || same_chain(u + 1);
  }

  bool area_agrees(Index facet, const Projection& projection) const {
    // A plain sum over a million faces would be off by more than the rounding that is allowed.
    DoubleWord before{0, 0}, after{0, 0};
    double absolute = 0, moved = 0;
    const auto at = [&](Index p) { return parts_.points[p]; };
    for (const Index f : faces_of(facet)) {
      const Face face = local_.wind(parts_.faces[f]);
      const double area = projection.twice_area(at(face[0]), at(face[1]), at(face[2]));
      before = before + DoubleWord{area, 0};
      absolute += std::abs(area);
    }
    for (const auto& t : triangulator_.triangles())
      after = after +
              DoubleWord{
                  projection.twice_area(at(local_.points[t[0]]), at(local_.points[t[1]]), at(local_.points[t[2]])), 0};
    double extent = 0;
    for (const Index i : piece_of_segment_) {
      const Piece& piece = parts_.pieces[i];
      const double run = length(at(piece.to) - at(piece.from));
      extent = std::max(extent, run);
      moved += 2 * piece.deviation * (run + 2 * piece.deviation);
    }
    const double rounding = 1e-12 * (absolute + extent * extent);
    return std::abs((after - before).high) <= moved + rounding;
  }

  // What the outline winds round, other faces cover; a needle that does not face as the facet does (any, in a facet
  // without a plane) may cover more, and nothing else tells how far that is from the result. Measured in the
  // plane, since the width has its own part in the bound.
  bool needles_stay_close(Index facet, Faces triangles, Patches& patches) {
    const Vec3 normal = parts_.planes[facet].normal;
    const std::vector<Index> folded = folded_needles(facet, normal);
    if (folded.empty()) return true;
    const Vec3 origin = parts_.points[parts_.faces[folded[0]][0]];
    const auto in_plane = [&](Index p) {
      const Vec3 d = parts_.points[p] - origin;
      return d - dot(normal, d) * normal;
    };
    std::vector<Vec3> points;
    for (const Index p : local_.points) points.push_back(in_plane(p));
    std::vector<Face> covered(triangles.begin(), triangles.end());
    for (const auto& [a, b] : local_.segments) covered.push_back({a, b, b});
    double extent = 0, enough = 0;
    for (const Index p : local_.points) extent = std::max(extent, length(parts_.points[p]));
    for (const Index i : piece_of_segment_) enough = std::max(enough, parts_.pieces[i].deviation);
    const double limit = parts_.reach[facet], rounding = 4 * std::numeric_limits<double>::epsilon() * extent;
    const FaceTree tree(points, covered);
    Certificate certificate(tree);
    bool close = true;
    for (const Index f : folded) {
      const Face& face = parts_.faces[f];
      const std::array needle{in_plane(face[0]), in_plane(face[1]), in_plane(face[2])};
      const double reach =
          certificate.bound(needle, std::max(enough, height(needle)), std::max(1e-3 * limit, rounding));
      if (reach <= rounding) continue;
      patches.reach.back() = std::max(patches.reach.back(), reach);
      if (reach <= limit) continue;
      close = false;
      for (int k = 0; k < 3; ++k) note_edge(facet, face[k], face[(k + 1) % 3], patches);
    }
    return close;
  }

  std::vector<Index> folded_needles(Index facet, Vec3 normal) const {
    std::vector<Index> folded;
    for (const Index f : faces_of(facet)) {
      const auto& [a, b, c] = parts_.faces[f];
      const Vec3 area_vector = cross(parts_.points[b] - parts_.points[a], parts_.points[c] - parts_.points[a]);
      if (dot(area_vector, normal) <= 0) folded.push_back(f);
    }
    return folded;
  }

  const FacetParts& parts_;
  const FacetChains& chains_;
  Triangulator triangulator_;
  LocalFacet local_;
  Array<Index> facet_of_point_;  // the facet whose points were counted last
  std::vector<Index> piece_of_segment_;
};

struct EdgeUse {
  Index low, high;
  FacetUse use;
  friend auto operator<=>(const EdgeUse&, const EdgeUse&) = default;
};

std::vector<EdgeUse> edge_uses(Faces triangles, Indices facet_of_triangle) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      const Index a = triangles[t][i], b = triangles[t][(i + 1) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), {facet_of_triangle[t], a < b}});
    }
  std::sort(uses.begin(), uses.end());
  return uses;
}

// Each facet that uses an edge inside itself uses it once each way.
bool all_inner(std::span<const EdgeUse> uses) {
  for (std::size_t i = 0; i < uses.size(); i += 2)
    if (i + 1 == uses.size() || uses[i].use.facet != uses[i + 1].use.facet ||
        uses[i].use.forward == uses[i + 1].use.forward)
      return false;
  return true;
}

// Pairs of triangles with the same corners and winding. All their edges are used twice the same way, so
// only triangles between `crowded` points (a flag for each) are looked at.
std::vector<IndexPair> find_copies(Faces triangles, Flags crowded) {
  std::vector<std::pair<Face, Index>> candidates;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Face face = triangles[t];
    if (!crowded[face[0]] || !crowded[face[1]] || !crowded[face[2]]) continue;
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    candidates.push_back({face, static_cast<Index>(t)});
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<IndexPair> copies;
  for (std::size_t i = 1; i < candidates.size(); ++i)
    if (candidates[i - 1].first == candidates[i].first)
      copies.push_back({candidates[i - 1].second, candidates[i].second});
  return copies;
}

std::size_t point_count_of(Faces triangles) {
  Index greatest = -1;
  for (const Face& t : triangles) greatest = std::max({greatest, t[0], t[1], t[2]});
  return static_cast<std::size_t>(greatest) + 1;
}

// Whether two uses of an edge run the same way.
bool is_crowded(std::span<const EdgeUse> uses) {
  const auto forward = std::count_if(uses.begin(), uses.end(), [](const EdgeUse& use) { return use.use.forward; });
  return forward > 1 || std::ssize(uses) - forward > 1;
}

}  // namespace

Patches retriangulate(const FacetParts& parts, Indices wanted, Flags keep) {
  const FacetChains chains(parts.outlines, parts.pieces, parts.planes.size());
  // Each thread has neighboring facets with about as many faces as any other's; what they make is put
  // together in the order of the facets.
  std::vector<std::size_t> work(wanted.size() + 1, 0);
  for (std::size_t i = 0; i < wanted.size(); ++i)
    work[i + 1] = work[i] + 1 + parts.face_start[wanted[i] + 1] - parts.face_start[wanted[i]];
  // A thread has arrays of its own over all points: a few threads, and memory stays low.
  const std::size_t least_work = std::max(least_parallel_work, parts.points.size() / 2);
  Patches patches;
  parallel_collect(
      work.back(),
      [&](std::size_t begin, std::size_t end) {
        const auto facet_at = [&](std::size_t w) {
          return std::lower_bound(work.begin(), work.end(), w) - work.begin();
        };
        Patches own;
        Retriangulator retriangulator(parts, chains);
        for (auto i = facet_at(begin); i < facet_at(end); ++i) retriangulator.run(wanted[i], keep[wanted[i]] != 0, own);
        return own;
      },
      [&](const Patches& own) {
        append(patches.triangles, own.triangles);
        append(patches.facet_of_triangle, own.facet_of_triangle);
        append(patches.outcomes, own.outcomes);
        append(patches.reach, own.reach);
        append(patches.put_back, own.put_back);
        append(patches.trouble, own.trouble);
        patches.statistics += own.statistics;
      },
      least_work);
  sort_unique(patches.put_back);
  sort_unique(patches.trouble);
  return patches;
}

std::vector<Misfit> find_misfits(Faces triangles, Indices facet_of_triangle, const PieceEdges& expected, Flags keep,
                                 const Outlines& outlines) {
  const std::vector<EdgeUse> uses = edge_uses(triangles, facet_of_triangle);
  std::vector<Misfit> misfits;
  const auto blame = [&](Index facet, Edge edge) {
    if (!keep[facet]) misfits.push_back({facet, edge[0], edge[1]});
  };
  std::vector<std::uint8_t> crowded;
  std::size_t e = 0;
  const auto expected_uses = [&] {
    return std::span<const FacetUse>(expected.uses.data() + expected.use_start[e],
                                     expected.uses.data() + expected.use_start[e + 1]);
  };
  const auto skip_missing = [&](Edge before) {
    for (; e < expected.edges.size() && expected.edges[e] < before; ++e)
      for (const FacetUse& use : expected_uses()) blame(use.facet, expected.edges[e]);
  };
  for (std::size_t from = 0; from < uses.size();) {
    std::size_t to = from + 1;
    while (to < uses.size() && uses[to].low == uses[from].low && uses[to].high == uses[from].high) ++to;
    const std::span<const EdgeUse> found(uses.data() + from, uses.data() + to);
    const Edge edge{uses[from].low, uses[from].high};
    from = to;
    if (is_crowded(found)) {
      if (crowded.empty()) crowded.assign(point_count_of(triangles), 0);
      crowded[edge[0]] = crowded[edge[1]] = 1;
    }
    skip_missing(edge);
    if (e < expected.edges.size() && expected.edges[e] == edge) {
      const auto wanted = expected_uses();
      const bool right = std::equal(found.begin(), found.end(), wanted.begin(), wanted.end(),
                                    [](const EdgeUse& a, const FacetUse& b) { return a.use == b; });
      if (!right) {
        for (const EdgeUse& use : found) blame(use.use.facet, edge);
        for (const FacetUse& use : wanted) blame(use.facet, edge);
      }
      ++e;
      continue;
    }
    const bool right =
        all_inner(found) &&
        (found.size() == 2 || (found.size() == 4 && outlines.back[found[0].use.facet] == found[2].use.facet));
    if (right) continue;
    // Where facets laid an inner edge on one another, it may stay in one of them.
    const bool one_may_stay = all_inner(found) && std::none_of(found.begin(), found.end(),
                                                               [&](const EdgeUse& use) { return keep[use.use.facet]; });
    for (const EdgeUse& use : found)
      if (!one_may_stay || use.use.facet != found[0].use.facet) blame(use.use.facet, edge);
  }
  skip_missing({std::numeric_limits<Index>::max(), 0});
  if (!crowded.empty()) {
    for (const auto& [first, second] : find_copies(triangles, crowded)) {
      const Face& face = triangles[second];
      const Index facet = facet_of_triangle[keep[facet_of_triangle[second]] ? first : second];
      for (int i = 0; i < 3; ++i)
        blame(facet, {std::min(face[i], face[(i + 1) % 3]), std::max(face[i], face[(i + 1) % 3])});
    }
  }
  sort_unique(misfits);
  return misfits;
}

}  // namespace bldsimp
