// Hole filling: what it closes is closed, near the surface, and crosses nothing.
#include <algorithm>
#include <random>
#include <vector>

#include "check.hpp"
#include "collapse/hole_filling.hpp"
#include "mesh/certificate.hpp"
#include "mesh/crossings.hpp"
#include "mesh/halfedges.hpp"

using namespace bldsimp;

namespace {

// A rough grid with holes.
void what_closes_is_closed() {
  constexpr Index side = 24;
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> rough(-0.2, 0.2), chance(0, 1);
  Index closed = 0, faces_made = 0;
  for (int round = 0; round < 60; ++round) {
    std::vector<Vec3> points;
    for (Index i = 0; i < side * side; ++i)
      points.push_back(
          {i % side + rough(generator), static_cast<double>(i / side) + rough(generator), rough(generator)});
    std::vector<Face> faces;
    const double gone = 0.02 * (round % 10);
    for (Index y = 0; y + 1 < side; ++y)
      for (Index x = 0; x + 1 < side; ++x) {
        const Index p = y * side + x;
        if (chance(generator) >= gone) faces.push_back({p, p + 1, p + side + 1});
        if (chance(generator) >= gone) faces.push_back({p, p + side + 1, p + side});
      }
    const std::vector<Index> label(faces.size(), 0);
    const std::vector<std::uint8_t> pinned(faces.size(), 0);
    const double limit = 0.3 + 0.2 * (round % 4);
    const HoleFilling filling = fill_holes(points, faces, label, pinned, limit);
    closed += filling.closed;
    faces_made += static_cast<Index>(filling.faces.size());
    std::vector<Face> all(faces);
    all.insert(all.end(), filling.faces.begin(), filling.faces.end());
    const auto before = count_edges(faces, side * side), after = count_edges(all, side * side);
    // Of a loop of n edges n - 2 faces are made, and each closes; no edge is used by more than two.
    CHECK(before[0] - after[0] == static_cast<Index>(filling.faces.size()) + 2 * filling.closed);
    CHECK(after[1] == 0);
    const FaceTree tree(points, faces);
    for (const auto& [a, b, c] : filling.faces)
      CHECK(Certificate(tree).bound({points[a], points[b], points[c]}, limit, 1e-6) <= limit + 1e-6);
    std::vector<std::uint8_t> wanted(all.size(), 0);
    std::fill(wanted.begin() + static_cast<std::ptrdiff_t>(faces.size()), wanted.end(), std::uint8_t{1});
    CHECK(find_crossings(points, all, wanted).empty());
  }
  CHECK(closed > 300);
  CHECK(faces_made > 500);
}

void pinned_loops_and_those_of_two_labels_stay() {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<Face> faces{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}};
  const auto closed = [&](std::vector<Index> label, std::vector<std::uint8_t> pinned) {
    return fill_holes(points, faces, label, pinned, 1.0).closed;
  };
  CHECK(closed({0, 0, 0}, {0, 0, 0}) == 1);
  CHECK(closed({0, 1, 0}, {0, 0, 0}) == 0);
  CHECK(closed({0, 0, 0}, {0, 1, 0}) == 0);
  CHECK(fill_holes({}, {}, {}, {}, 1.0).closed == 0);
}

}  // namespace

int main() {
  RUN(what_closes_is_closed);
  RUN(pinned_loops_and_those_of_two_labels_stay);
  return check::report();
}
