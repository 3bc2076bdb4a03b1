// Bodies, and which of them the others hold: what goes is near what stays, whatever lies about.
#include <algorithm>
#include <random>
#include <vector>

#include "check.hpp"
#include "collapse/bodies.hpp"
#include "collapse/redundant_bodies.hpp"
#include "mesh/certificate.hpp"
#include "mesh/halfedges.hpp"

using namespace bldsimp;

namespace {

constexpr double kLimit = 0.25;

struct Heap {
  std::vector<Vec3> points;
  std::vector<Face> faces;
};

// Boxes on a coarse grid, so that many share points, edges and walls; and triangles between any of their points.
Heap random_heap(std::mt19937_64& generator, int boxes, int triangles) {
  constexpr Index side = 5;
  std::uniform_int_distribution<Index> place(0, side - 1), corner(0, side * side * side - 1);
  const auto at = [](Index x, Index y, Index z) { return (z * side + y) * side + x; };
  Heap heap;
  for (Index i = 0; i < side * side * side; ++i)
    heap.points.push_back({0.2 * (i % side), 0.2 * (i / side % side), 0.2 * (i / side / side)});
  for (int b = 0; b < boxes; ++b) {
    std::array<IndexPair, 3> range;
    for (auto& [low, high] : range) {
      do low = place(generator), high = place(generator);
      while (low >= high);
    }
    const auto [x, y, z] = range;
    const std::array<Index, 8> c{at(x[0], y[0], z[0]), at(x[1], y[0], z[0]), at(x[1], y[1], z[0]),
                                 at(x[0], y[1], z[0]), at(x[0], y[0], z[1]), at(x[1], y[0], z[1]),
                                 at(x[1], y[1], z[1]), at(x[0], y[1], z[1])};
    for (const auto& [p, q, r, s] : {std::array{0, 3, 2, 1}, std::array{4, 5, 6, 7}, std::array{0, 1, 5, 4},
                                     std::array{2, 3, 7, 6}, std::array{3, 0, 4, 7}, std::array{1, 2, 6, 5}}) {
      heap.faces.push_back({c[p], c[q], c[r]});
      heap.faces.push_back({c[p], c[r], c[s]});
    }
  }
  for (int t = 0; t < triangles; ++t) {
    const Face face{corner(generator), corner(generator), corner(generator)};
    if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) heap.faces.push_back(face);
  }
  return heap;
}

std::vector<Face> chosen(const Heap& heap, const std::vector<std::uint8_t>& spare, bool gone) {
  std::vector<Face> faces;
  for (std::size_t f = 0; f < heap.faces.size(); ++f)
    if ((spare[f] != 0) == gone) faces.push_back(heap.faces[f]);
  return faces;
}

void what_goes_is_near_what_stays() {
  std::mt19937_64 generator(1);
  int gone = 0;
  for (int round = 0; round < 300; ++round) {
    const Heap heap = random_heap(generator, round % 12, round % 7 * 3);
    if (heap.faces.empty()) continue;
    const auto body = find_bodies(heap.points, heap.faces);
    const std::vector<std::uint8_t> pinned(heap.faces.size(), 0);
    const auto spare = find_redundant_bodies(heap.points, heap.faces, body, pinned, kLimit);
    for (std::size_t f = 0; f < body.size(); ++f) CHECK(spare[f] == spare[body[f]]);
    const auto left = chosen(heap, spare, false), went = chosen(heap, spare, true);
    CHECK(!left.empty());
    gone += static_cast<int>(went.size());
    const FaceTree tree(heap.points, left);
    for (const auto& [a, b, c] : went)
      CHECK(Certificate(tree).bound({heap.points[a], heap.points[b], heap.points[c]}, kLimit, 1e-6) <= kLimit + 1e-6);
    const auto count = static_cast<Index>(heap.points.size());
    CHECK(count_edges(left, count)[0] <= count_edges(heap.faces, count)[0]);
  }
  CHECK(gone > 1000);
}

void boxes_that_share_a_wall_are_bodies_of_their_own() {
  // Two boxes side by side, and one on top of both.
  std::vector<Vec3> points;
  for (int i = 0; i < 18; ++i) points.push_back({i % 3 - 1.0, 1.0 * (i / 3 % 2), 1.0 * (i / 6)});
  std::vector<Face> faces;
  const auto add = [&](std::array<Index, 8> c) {
    for (const auto& [p, q, r, s] : {std::array{0, 3, 2, 1}, std::array{4, 5, 6, 7}, std::array{0, 1, 5, 4},
                                     std::array{2, 3, 7, 6}, std::array{3, 0, 4, 7}, std::array{1, 2, 6, 5}}) {
      faces.push_back({c[p], c[q], c[r]});
      faces.push_back({c[p], c[r], c[s]});
    }
  };
  add({0, 1, 4, 3, 6, 7, 10, 9});
  add({1, 2, 5, 4, 7, 8, 11, 10});
  add({6, 7, 10, 9, 12, 13, 16, 15});
  const auto body = find_bodies(points, faces);
  for (std::size_t f = 0; f < faces.size(); ++f) CHECK(body[f] == static_cast<Index>(f / 12 * 12));
}

void points_too_near_to_tell_apart_are_no_obstacle() {
  const std::vector<Vec3> points{{0, 0, 0}, {1e-200, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}};
  const std::vector<Face> faces{{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 0, 5}};
  const auto body = find_bodies(points, faces);
  CHECK(body.size() == 4);
  CHECK(find_redundant_bodies(points, faces, body, std::vector<std::uint8_t>(4, 0), 0.1).size() == 4);
}

void nothing_has_nothing_to_spare() {
  CHECK(find_bodies({}, {}).empty());
  CHECK(find_redundant_bodies({}, {}, {}, {}, 1.0).empty());
}

}  // namespace

int main() {
  RUN(what_goes_is_near_what_stays);
  RUN(boxes_that_share_a_wall_are_bodies_of_their_own);
  RUN(points_too_near_to_tell_apart_are_no_obstacle);
  RUN(nothing_has_nothing_to_spare);
  return check::report();
}
