// Crossings of a mesh that changes, beside a search through all of its faces after each step.
#include "mesh/crossings.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "check.hpp"

using namespace bldsimp;

namespace {

struct Mesh {
  std::vector<Vec3> points;
  std::vector<Face> faces;
  std::vector<bool> gone;

  // A square of cells, its points a little up or down.
  void add_sheet(std::mt19937_64& generator, int cells, double height, double noise) {
    std::uniform_real_distribution<double> up(-noise, noise);
    const auto first = static_cast<Index>(points.size());
    for (int x = 0; x <= cells; ++x)
      for (int y = 0; y <= cells; ++y)
        points.push_back({static_cast<double>(x), static_cast<double>(y), height + up(generator)});
    for (int x = 0; x < cells; ++x)
      for (int y = 0; y < cells; ++y) {
        const Index a = first + x * (cells + 1) + y, b = a + cells + 1;
        faces.push_back({a, b, b + 1});
        faces.push_back({a, b + 1, a + 1});
      }
    gone.assign(faces.size(), false);
  }
  std::vector<Index> star(Index p) const {
    std::vector<Index> found;
    for (std::size_t f = 0; f < faces.size(); ++f)
      if (!gone[f] && std::find(faces[f].begin(), faces[f].end(), p) != faces[f].end())
        found.push_back(static_cast<Index>(f));
    return found;
  }
  std::size_t crossings() const {
    std::vector<Face> left;
    for (std::size_t f = 0; f < faces.size(); ++f)
      if (!gone[f]) left.push_back(faces[f]);
    return find_crossings(points, left, std::vector<std::uint8_t>(left.size(), 1)).size();
  }
};

// One step: a goes to b, or to a place of its own where b is a.
struct Step {
  Step(const Mesh& mesh, Index a, Index b, Vec3 to) : from(a), target(to), old(mesh.star(a)) {
    for (const Index f : old) {
      Face face = mesh.faces[f];
      std::replace(face.begin(), face.end(), a, b);
      if (a != b && std::count(face.begin(), face.end(), b) > 1) continue;
      IndexedTriangle triangle{face, {}};
      for (int i = 0; i < 3; ++i) triangle.at[i] = face[i] == b ? to : mesh.points[face[i]];
      fresh.push_back({f, triangle});
    }
    for (const Index f : old)
      for (const Index p : mesh.faces[f]) {
        if (p == a) continue;
        for (const Index g : mesh.star(p))
          if (std::find(old.begin(), old.end(), g) == old.end()) around.push_back(g);
      }
  }
  Mesh after(Mesh mesh) const {
    for (const Index f : old) mesh.gone[f] = true;
    for (const auto& [slot, triangle] : fresh) {
      mesh.gone[slot] = false;
      mesh.faces[slot] = triangle.face;
      if (triangle.face[0] == from || triangle.face[1] == from || triangle.face[2] == from) mesh.points[from] = target;
    }
    return mesh;
  }

  Index from;
  Vec3 target;
  std::vector<Index> old, around;
  std::vector<CrossingTracker::Change> fresh;
};

// Points go onto neighbors and to other places, two sheets at a distance that the noise nearly fills.
void steps_are_told_as_a_search_tells() {
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::mt19937_64 generator(seed);
    Mesh mesh;
    mesh.add_sheet(generator, 7, 0.0, 0.1);
    mesh.add_sheet(generator, 7, 0.21, 0.1);
    CHECK(mesh.crossings() == 0);
    CrossingTracker crossings(mesh.points, mesh.faces, {});
    int refused = 0, accepted = 0;
    for (int i = 0; i < 600; ++i) {
      const auto a = static_cast<Index>(generator() % mesh.points.size());
      const auto star = mesh.star(a);
      if (star.empty()) continue;
      const bool moves = i % 4 != 0;
      const Index b = moves ? a : mesh.faces[star[generator() % star.size()]][generator() % 3];
      if (b == a && !moves) continue;
      Vec3 to = mesh.points[b];
      if (moves) to.z += std::uniform_real_distribution<double>(-0.3, 0.3)(generator);
      const Step step(mesh, a, b, to);
      const bool made = crossings.makes_crossing(step.old, step.around, step.fresh);
      const Mesh after = step.after(mesh);
      CHECK(made == (after.crossings() > 0));
      ++(made ? refused : accepted);
      if (made) continue;
      crossings.commit(step.old, step.fresh);
      // In place, since the other watches these points.
      std::copy(after.points.begin(), after.points.end(), mesh.points.begin());
      mesh.faces = after.faces;
      mesh.gone = after.gone;
    }
    CHECK(refused > 30 && accepted > 150);
  }
}

// A wall stands across a sheet. There, points may go that would be refused were there no crossing before, as long as
// no more pairs cross.
void where_faces_cross_they_may_go_on_to() {
  std::mt19937_64 generator(6);
  Mesh mesh;
  mesh.add_sheet(generator, 8, 0.0, 0.01);
  const auto first = static_cast<Index>(mesh.points.size());
  for (const auto& [y, z] :
       {std::array{-1.0, -9.0}, std::array{9.0, -9.0}, std::array{9.0, 9.0}, std::array{-1.0, 9.0}})
    mesh.points.push_back({3.9 + z / 100, y, z});
  mesh.faces.push_back({first, first + 1, first + 2});
  mesh.faces.push_back({first, first + 2, first + 3});
  mesh.gone.assign(mesh.faces.size(), false);
  const CrossingTracker crossings(mesh.points, mesh.faces, {});
  const std::size_t before = mesh.crossings();
  const auto at = [](int x, int y) { return static_cast<Index>(9 * x + y); };
  int moved_on = 0;
  for (int x = 3; x <= 4; ++x)
    for (int y = 1; y <= 7; ++y)
      for (const auto& [dx, dy] : {std::array{1, 0}, std::array{-1, 0}, std::array{0, 1}, std::array{0, -1}}) {
        const Step step(mesh, at(x, y), at(x + dx, y + dy), mesh.points[at(x + dx, y + dy)]);
        const bool made = crossings.makes_crossing(step.old, step.around, step.fresh);
        CHECK(made == (step.after(mesh).crossings() > before));
        moved_on += !made;
      }
  CHECK(before > 0 && moved_on > 0);
}

// The sheets cross along the middle.
void what_does_not_cross_may_not_come_to() {
  std::mt19937_64 generator(4);
  Mesh mesh;
  mesh.add_sheet(generator, 8, 0.0, 0.01);
  mesh.add_sheet(generator, 8, 0.0, 0.01);
  for (std::size_t i = 81; i < mesh.points.size(); ++i) mesh.points[i].z += 0.5 * (mesh.points[i].x - 3.9);
  CHECK(mesh.crossings() > 0);
  const CrossingTracker crossings(mesh.points, mesh.faces, {});
  const auto told = [&](Index a, Index b, const CrossingTracker& by) {
    const Step step(mesh, a, b, mesh.points[b]);
    return by.makes_crossing(step.old, step.around, step.fresh);
  };
  const auto at = [](int x, int y) { return static_cast<Index>(9 * x + y); };
  CHECK(!told(at(1, 4), at(2, 4), crossings));
  // A lone move up at the far side pierces the other sheet where nothing crosses.
  Vec3 up = mesh.points[at(7, 4)];
  up.z += 3;
  const Step far(mesh, at(7, 4), at(7, 4), up);
  CHECK(crossings.makes_crossing(far.old, far.around, far.fresh));
  // What is beside is not of the same mesh, and nothing may cross it.
  const std::span<const Face> all(mesh.faces);
  const CrossingTracker lower(mesh.points, all.first(128), all.subspan(128));
  CHECK(told(at(4, 4), at(5, 4), lower));
  CHECK(!told(at(1, 4), at(2, 4), lower));
}

void threads_leave_no_trace() {
  std::mt19937_64 generator(5);
  Mesh mesh;
  mesh.add_sheet(generator, 40, 0.0, 0.1);
  mesh.add_sheet(generator, 40, 0.05, 0.1);
  const std::vector<std::uint8_t> all(mesh.faces.size(), 1);
  const auto pairs = find_crossings(mesh.points, mesh.faces, all);
  CHECK(!pairs.empty());
  CHECK(std::is_sorted(pairs.begin(), pairs.end()));
  for (std::size_t f = 0; f < mesh.faces.size(); f += 7) {
    std::vector<std::uint8_t> wanted(mesh.faces.size(), 0);
    wanted[f] = 1;
    const auto own = find_crossings(mesh.points, mesh.faces, wanted);
    const auto has = [&](const auto& pair) {
      return pair[0] == static_cast<Index>(f) || pair[1] == static_cast<Index>(f);
    };
    CHECK(static_cast<std::size_t>(std::count_if(pairs.begin(), pairs.end(), has)) == own.size());
    CHECK(std::all_of(own.begin(), own.end(), has));
  }
}

}  // namespace

int main() {
  RUN(steps_are_told_as_a_search_tells);
  RUN(where_faces_cross_they_may_go_on_to);
  RUN(what_does_not_cross_may_not_come_to);
  RUN(threads_leave_no_trace);
  return check::report();
}
