// Run all kernels one after the other, as the stages of the package do, on small random meshes.
#include <limits>

#include "check.hpp"
#include "collapse/bodies.hpp"
#include "collapse/collapse.hpp"
#include "collapse/redundant_bodies.hpp"
#include "details/features.hpp"
#include "mesh/crossings.hpp"
#include "mesh/distances.hpp"
#include "mesh/halfedges.hpp"
#include "mesh/orient.hpp"
#include "mesh/weld.hpp"
#include "planar/charts.hpp"
#include "planar/conform.hpp"
#include "planar/facets.hpp"
#include "planar/outlines.hpp"
#include "planar/retriangulate.hpp"
#include "planar/row_assignment.hpp"
#include "planar/thin.hpp"
#include "shapes.hpp"

using namespace bldsimp;
using shapes::Random;
using shapes::Soup;

namespace {

using FlagList = std::vector<std::uint8_t>;

struct Surface {
  std::vector<Vec3> points;
  std::vector<Face> faces;
};

Index count_of(const Surface& s) { return static_cast<Index>(s.points.size()); }
Triangle corners(const Surface& s, const Face& f) { return {s.points[f[0]], s.points[f[1]], s.points[f[2]]}; }

// How far some places of each face of a surface are from another one at most.
double farthest(const Surface& from, const Surface& to) {
  std::vector<Vec3> places;
  for (const Face& f : from.faces) {
    const auto [a, b, c] = corners(from, f);
    places.insert(places.end(), {a, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (1.0 / 3) * (a + b + c)});
  }
  return FaceTree(to.points, to.faces).farthest(places, std::numeric_limits<double>::infinity());
}

std::size_t count_crossings(const Surface& s) {
  return find_crossings(s.points, s.faces, FlagList(s.faces.size(), 1)).size();
}

// A welded mesh with windings that agree.
struct Welding {
  Welding(const Soup& soup, double distance, double width)
      : input(soup), welded(weld(soup.points, soup.faces, distance, {})) {
    rows = {input.faces, welded.point_of_row, welded.source, welded.class_of_row};
    surface = {{welded.points.begin(), welded.points.end()}, {welded.faces.begin(), welded.faces.end()}};
    halfedges = pair_halfedges(surface.points, surface.faces, rows, width);
    const FlagList fixed(surface.faces.size(), 0);
    for (const Index f : find_misoriented(surface.points, surface.faces, halfedges, rows, fixed))
      std::swap(surface.faces[f][1], surface.faces[f][2]);
    halfedges = pair_halfedges(surface.points, surface.faces, rows, width);
    CHECK(find_misoriented(surface.points, surface.faces, halfedges, rows, fixed).empty());
    CHECK(std::is_sorted(surface.points.begin(), surface.points.end(), lexicographic_less));
    CHECK(welded.faces.size() + welded.degenerate + welded.duplicate == soup.faces.size());
    CHECK(welded.moved <= distance);
  }

  const Soup& input;
  WeldResult welded;
  CornerRows rows;
  Surface surface;
  Halfedges halfedges;
};

// Thins and retriangulates facets; what does not fit keeps its faces, until everything fits.
class Merger {
 public:
  Merger(const Welding& mesh, const Facets& found, double limit)
      : points(mesh.surface.points), faces(mesh.surface.faces), facets(found), groups(group_faces(found)),
        keep(found.planes.size(), 0), must(points.size(), 0), limit_(limit), halfedges_(mesh.halfedges) {
    for (int round = 0; !settle(); ++round) CHECK(round < 1000);
  }

  std::span<const Vec3> points;
  std::span<const Face> faces;
  Facets facets;
  Groups groups;
  FlagList keep, must, kept;
  Outlines outlines;
  std::vector<Piece> pieces;
  Patches patches;

 private:
  bool settle() {
    outlines = trace_outlines(faces, static_cast<Index>(points.size()), halfedges_, facets, keep);
    FlagList stay(must);
    for (std::size_t p = 0; p < points.size(); ++p) stay[p] |= outlines.is_chain_end[p];
    for (std::size_t f = 0; f < faces.size(); ++f)
      if (keep[facets.facet_of_face[f]])
        for (const Index p : faces[f]) stay[p] = 1;
    const std::vector<double> limits(outlines.chain_start.size() - 1, limit_), reach(keep.size(), limit_);
    kept = thin_chains(points, outlines, limits, stay);
    pieces = lay_pieces(points, outlines, kept);
    for (const Piece& piece : pieces) CHECK(piece.deviation <= limit_);
    const PieceEdges edges = merge_pieces(pieces, outlines);
    for (const Index p : edges.clashing) must[p] = 1;
    if (!edges.clashing.empty()) return false;
    std::vector<Index> all(keep.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
    patches = retriangulate({points, faces, groups.start, groups.members, facets.planes, outlines, pieces, kept, reach},
                            all, keep);
    FlagList unchanged(keep.size(), 0);
    bool fits = true;
    for (std::size_t i = 0; i < all.size(); ++i) {
      unchanged[i] = patches.outcomes[i] == Outcome::unchanged;
      if (patches.outcomes[i] < Outcome::crossing) continue;
      keep[i] = 1;
      fits = false;
    }
    if (!fits) return false;
    const auto misfits = find_misfits(patches.triangles, patches.facet_of_triangle, edges, unchanged, outlines);
    for (const Misfit& misfit : misfits) keep[misfit.facet] = 1;
    return misfits.empty();
  }

  double limit_;
  const Halfedges& halfedges_;
};

void check_rows(const Welding& mesh, const Merger& merger) {
  FlagList unchanged(merger.keep.size(), 0);
  for (std::size_t i = 0; i < unchanged.size(); ++i) unchanged[i] = merger.patches.outcomes[i] == Outcome::unchanged;
  const std::vector<Index> one(unchanged.size(), 0);
  FlagList used(merger.points.size(), 0);
  for (const Face& t : merger.patches.triangles)
    for (const Index p : t) used[p] = 1;
  const auto found = assign_rows(merger.patches.triangles, merger.patches.facet_of_triangle, merger.faces, mesh.rows,
                                 merger.facets.facet_of_face, one, one, unchanged, used);
  for (std::size_t t = 0; t < found.rows.size(); ++t)
    for (int i = 0; i < 3; ++i) CHECK(mesh.welded.point_of_row[found.rows[t][i]] == merger.patches.triangles[t][i]);
}

void check_conforming(const Merger& merger) {
  const auto& [triangles, facet_of_triangle, outcomes, reach, put_back, trouble, statistics] = merger.patches;
  const auto result = conform(
      {merger.points, merger.facets.planes, merger.outlines, merger.pieces, triangles, facet_of_triangle, merger.keep});
  std::vector<Vec3> points(merger.points.begin(), merger.points.end());
  points.insert(points.end(), result.made.begin(), result.made.end());
  const auto area_vector = [&](const std::vector<Face>& faces) {
    Vec3 sum{0, 0, 0};
    for (const auto& [a, b, c] : faces) sum = sum + cross(points[b] - points[a], points[c] - points[a]);
    return sum;
  };
  CHECK(length(area_vector(result.triangles) - area_vector(triangles)) < 1e-6);
  CHECK(std::is_sorted(result.facet_of_triangle.begin(), result.facet_of_triangle.end()));
}

// A value for each row that is affine in space, but for a few rows.
void check_charts(const Welding& mesh, const Groups& groups, Random& random) {
  std::vector<double> values;
  for (const Vec3& p : mesh.input.points)
    values.push_back(p.x + 2 * p.y - p.z + (random() % 20 ? 0 : shapes::uniform(random, 0, 1)));
  const std::vector<double> steps{100}, limits{1};
  const std::vector<Index> part(mesh.surface.faces.size(), 0);
  const auto charts = find_charts(mesh.surface.points, mesh.surface.faces, mesh.halfedges, groups.start, groups.members,
                                  mesh.rows, part, {values, steps, limits});
  for (const Index chart : charts.chart_of_face) CHECK(0 <= chart && chart < std::ssize(charts.spans));
  for (const double span : charts.spans) CHECK(span <= limits[0]);
  const std::vector<Vec3> normals(mesh.input.points.size(), Vec3{0, 0, 1});
  const auto smooth = find_smooth(mesh.surface.points, mesh.surface.faces, mesh.halfedges, mesh.rows, normals, 0.9, 0);
  for (std::size_t f = 0; f < smooth.size(); ++f)
    CHECK(smooth[smooth[f]] == smooth[f] && smooth[f] <= static_cast<Index>(f));
}

// Merges what is coplanar within a tolerance; how many points that saves.
std::size_t check_planar(const Soup& soup, double tolerance, Random& random) {
  const double width = 0.5 * tolerance;
  const Welding mesh(soup, 0, width);
  std::vector<Index> label(mesh.surface.faces.size(), 0);
  if (random() % 2)
    for (Index& l : label) l = random() % 40 ? 0 : 1;
  Facets facets = find_facets(mesh.surface.points, mesh.surface.faces, mesh.halfedges, label, {1, 1, 1},
                              {width, 1e-3 * tolerance, 0.5 * tolerance});
  if (random() % 3 == 0 && !label.empty()) facets = split_off(facets, std::vector<Index>{0});
  for (const Plane& plane : facets.planes) CHECK(plane.high - plane.low <= std::max(width, 1e-12));
  const Merger merger(mesh, facets, 0.5 * tolerance);
  check_charts(mesh, merger.groups, random);
  if (merger.patches.triangles.empty()) return 0;
  check_rows(mesh, merger);
  check_conforming(merger);
  const Surface after{mesh.surface.points, merger.patches.triangles};
  CHECK(farthest(after, mesh.surface) <= tolerance);
  CHECK(farthest(mesh.surface, after) <= tolerance);
  const auto before = count_edges(mesh.surface.faces, count_of(mesh.surface));
  CHECK(count_edges(after.faces, count_of(after))[0] <= before[0]);
  const Array<std::uint8_t> used = mark_used(after.faces, after.points.size());
  return after.points.size() - static_cast<std::size_t>(std::count(used.begin(), used.end(), 1));
}

// Removes, fills and collapses what a tolerance allows; how many points that saves.
std::size_t check_wide(const Soup& soup, double tolerance, Random& random) {
  const Welding mesh(soup, 0, 0);
  const Surface& surface = mesh.surface;
  const auto body = find_bodies(surface.points, surface.faces);
  FlagList pinned(surface.faces.size(), 0);
  std::vector<Index> label(surface.faces.size(), 0);
  for (std::size_t f = 0; f < body.size(); ++f) {
    CHECK(body[f] <= static_cast<Index>(f) && body[body[f]] == body[f]);
    pinned[f] = random() % 50 == 0;
    label[f] = random() % 50 == 0;
  }
  const FlagList redundant = find_redundant_bodies(surface.points, surface.faces, body, pinned, 0.9 * tolerance);
  const bool moves = random() % 2, keeps = random() % 2;
  const Rounding rounding{moves ? 4 : -1, false};
  const FeatureRemoval removal =
      remove_features({surface.points, surface.faces, label, label, FlagList(surface.points.size(), 1), pinned,
                       redundant, 0.9 * tolerance, 1e-9, rounding, keeps, static_cast<Index>(surface.faces.size())});
  std::vector<Face> all(surface.faces);
  FlagList left_out(removal.left_out);
  for (std::size_t f = 0; f < removal.faces.size(); ++f) {
    all.push_back(removal.faces[f]);
    label.push_back(label[removal.parent[f]]);
    pinned.push_back(0);
    left_out.push_back(0);
  }
  Progress progress;
  const CollapseResult result = collapse({surface.points,
                                          all,
                                          label,
                                          pinned,
                                          left_out,
                                          static_cast<Index>(removal.faces.size()),
                                          tolerance,
                                          rounding.decimals,
                                          false,
                                          &progress,
                                          {},
                                          removal.points});
  CHECK(progress.removed == result.accepted);
  CHECK(result.deviation <= tolerance);
  CHECK(moves || result.moved == 0);
  if (result.triangles.empty()) return 0;
  const Surface after{result.points, result.triangles};
  CHECK(farthest(surface, after) <= tolerance);
  CHECK(farthest(after, surface) <= tolerance);
  for (const Index holder : result.holder) CHECK(-1 <= holder && holder < std::ssize(result.triangles));
  for (std::size_t t = 0; t < result.source.size(); ++t)
    if (pinned[result.source[t]]) CHECK(result.triangles[t] == all[result.source[t]]);
  const auto count = count_of(surface);
  CHECK(count_edges(after.faces, count)[1] <= count_edges(surface.faces, count)[1]);
  if (count_crossings(surface) == 0) CHECK(count_crossings(after) == 0);
  return static_cast<std::size_t>(result.accepted);
}

template <class Make>
void run_all(int seed, int rounds, Make make) {
  Random random(seed);
  std::size_t merged = 0, collapsed = 0;
  for (int round = 0; round < rounds; ++round) {
    Soup soup = make(random, round);
    if (round % 2) shapes::turn_some(random, soup, 0.1);
    merged += check_planar(soup, round % 3 == 0 ? 1e-6 : 0.05, random);
    collapsed += check_wide(soup, round % 3 == 0 ? 0.05 : 0.6, random);
  }
  CHECK(merged > static_cast<std::size_t>(rounds));
  CHECK(collapsed > static_cast<std::size_t>(rounds));
}

void boxes_with_windows() {
  run_all(1, 6, [](Random& random, int round) {
    Soup soup = shapes::block_with_windows(random, 3 + round % 3, 0.1, round % 4 ? 1 : 0.5);
    if (round % 2) shapes::rotate(soup, 0.1 * round);
    if (round % 5 == 0) shapes::add_noise(random, soup, 1e-3);
    return soup;
  });
}

void noisy_sheets() {
  run_all(2, 6, [](Random& random, int round) {
    Soup soup = shapes::noisy_sheet(random, 8 + round % 5, round % 2 ? 0.01 : 0.15, 0.02 * (round % 4));
    // Flat ones have rims to thin; of two that are near each other none may come to cross the other.
    if (round % 3 == 1)
      for (Vec3& p : soup.points) p.z = 0;
    if (round % 3 == 2) shapes::append(soup, shapes::noisy_sheet(random, 9, 0.1, 0), {0.1, 0.2, 0.28});
    return soup;
  });
}

void unions_that_share_edges() {
  run_all(3, 4, [](Random& random, int round) {
    Soup soup = shapes::block_with_windows(random, 4, 0.5, 1);
    const Vec3 shift{1.0 * (round % 3), 0.5 * (round % 2), 1};
    shapes::append(soup, shapes::block_with_windows(random, 3, 0.2, 1), shift);
    shapes::append(soup, shapes::box({0.2, 0.2, 0.2}, {0.6, 0.6, 0.6}), {0, 0, 0});
    return soup;
  });
}

void needles_and_copies() {
  run_all(4, 6, [](Random& random, int round) {
    Soup soup = round % 2 ? shapes::block_with_windows(random, 3, 0.1, 0.9) : shapes::noisy_sheet(random, 9, 1e-3, 0);
    shapes::add_needles(random, soup, 12, round % 3 ? 1e-4 : 0);
    shapes::add_copies(random, soup, 6);
    return soup;
  });
}

void nothing_stays_nothing() {
  Random random(5);
  CHECK(check_planar({}, 0.1, random) == 0);
  CHECK(check_wide({}, 0.1, random) == 0);
}

}  // namespace

int main() {
  RUN(boxes_with_windows);
  RUN(noisy_sheets);
  RUN(unions_that_share_edges);
  RUN(needles_and_copies);
  RUN(nothing_stays_nothing);
  return check::report();
}
