// Bodies, and which of them the others hold: what goes is near what stays, whatever lies about.
#include <algorithm>
#include <random>
#include <vector>

#include "check.hpp"
#include "collapse/bodies.hpp"
#include "collapse/holder_normals.hpp"
#include "collapse/redundant_bodies.hpp"
#include "mesh/certificate.hpp"
#include "mesh/halfedges.hpp"
#include "shapes.hpp"

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

// Whether a face that needs it lies over something roughly parallel at some of its points.
bool lies_over(const Triangle& face, Vec3 normal, Points points, Faces rest) {
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; i + j <= 4; ++j) {
      const Vec3 p = face[0] + (0.25 * i) * (face[1] - face[0]) + (0.25 * j) * (face[2] - face[0]);
      if (std::none_of(rest.begin(), rest.end(), [&](const Face& f) {
            const auto [a, b, c] = corners_of(f, points);
            const FramedTriangle holder(a, b, c);
            return holder.is_across(normal) && holder.lies_under(p, kLimit + 1e-9);
          }))
        return false;
    }
  return true;
}

Heap collect(std::initializer_list<shapes::Soup> soups) {
  Heap heap;
  for (const auto& soup : soups) {
    const auto first = static_cast<Index>(heap.points.size());
    append(heap.points, soup.points);
    for (const auto& [a, b, c] : soup.faces) heap.faces.push_back({first + a, first + b, first + c});
  }
  return heap;
}

shapes::Soup inside_out(shapes::Soup soup) {
  for (auto& [a, b, c] : soup.faces) std::swap(b, c);
  return soup;
}

std::vector<std::uint8_t> find_spare(const Heap& heap, double limit) {
  const auto body = find_bodies(heap.points, heap.faces);
  return find_redundant_bodies(heap.points, heap.faces, body, std::vector<std::uint8_t>(heap.faces.size(), 0), limit);
}

// The numbers of the shapes that go, of boxes.
std::vector<Index> gone_boxes(const Heap& heap, double limit) {
  const auto spare = find_spare(heap, limit);
  std::vector<Index> gone;
  for (std::size_t f = 0; f < spare.size(); f += 12)
    if (spare[f]) gone.push_back(static_cast<Index>(f / 12));
  return gone;
}

void what_goes_is_near_what_stays() {
  std::mt19937_64 generator(1);
  int gone = 0, needy = 0;
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
    std::vector<Face> own;
    for (std::size_t f = 0; f < body.size(); ++f) {
      if (!spare[f] || body[f] != static_cast<Index>(f)) continue;
      own.clear();
      for (std::size_t g = f; g < body.size(); ++g)
        if (body[g] == body[f]) own.push_back(heap.faces[g]);
      const auto normals = find_holder_normals(heap.points, own, kLimit);
      for (std::size_t g = 0; g < own.size(); ++g) {
        if (normals[g] == Vec3{0, 0, 0}) continue;
        ++needy;
        CHECK(lies_over(corners_of(own[g], heap.points), normals[g], heap.points, left));
      }
    }
    const auto count = static_cast<Index>(heap.points.size());
    CHECK(count_edges(left, count)[0] <= count_edges(heap.faces, count)[0]);
  }
  CHECK(gone > 1000);
  CHECK(needy > 100);
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

void a_panel_square_to_slabs_stays() {
  using shapes::box;
  const auto floor = box({0, 0, -0.3}, {20, 14, 0}), ceiling = box({0, 0, 2.7}, {20, 14, 3});
  // All of it is within the limit of the slabs, and near their rims, which are parallel to it but lie beside it.
  const Heap storey = collect({floor, ceiling, box({0, 0, 0}, {5, 0.25, 2.7})});
  CHECK(gone_boxes(storey, 1.4).empty());
  CHECK(gone_boxes(storey, 2.0).empty());
  // It is low beside the limit.
  CHECK((gone_boxes(storey, 2.8) == std::vector<Index>{2}));
  // All of a storey in one.
  const Heap block = collect({floor, ceiling, box({0, 0, 0}, {20, 14, 2.7})});
  CHECK((gone_boxes(block, 1.4) == std::vector<Index>{0, 1}));
  // The panel before a wall goes, however square the slabs are to it.
  CHECK((gone_boxes(collect({floor, ceiling, box({0, 0, 0}, {5, 0.25, 2.7}), box({0, 0.5, 0}, {6, 1, 2.7})}), 0.8) ==
         std::vector<Index>{2}));
}

void small_and_narrow_bodies_need_nothing_parallel() {
  using shapes::box;
  const auto wall = box({0, 0, 0}, {4, 0.3, 3});
  // A cube, of which some faces are square to the wall; and a bar.
  CHECK((gone_boxes(collect({wall, box({1, -0.2, 1}, {1.2, 0, 1.2})}), 0.21) == std::vector<Index>{1}));
  CHECK((gone_boxes(collect({wall, box({1, -0.2, 1}, {3, 0, 1.05})}), 0.21) == std::vector<Index>{1}));
  CHECK(gone_boxes(collect({wall, box({1, -0.2, 1}, {3, 0, 1.05})}), 0.19).empty());
}

void a_face_of_45_degrees_is_parallel() {
  // A strip before a slope that rises by so much for each unit.
  const auto gone = [](double slope) {
    Heap heap;
    heap.points = {{0, -4, -4 * slope}, {9, -4, -4 * slope}, {9, 4, 4 * slope}, {0, 4, 4 * slope},
                   {1, -0.4, 0},        {8, -0.4, 0},        {8, 0.4, 0},       {1, 0.4, 0}};
    heap.faces = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    return find_spare(heap, 0.39)[2] != 0;
  };
  CHECK(gone(0.9));
  CHECK(gone(1.0));
  CHECK(!gone(1.1));
}

void an_inner_shell_belongs_to_its_body() {
  using shapes::box;
  const auto outer = box({0, 0, 0}, {2, 2, 2}), inner = box({0.1, 0.1, 0.1}, {1.9, 1.9, 1.9});
  const Heap hollow = collect({outer, inside_out(inner)});
  for (const Index b : find_bodies(hollow.points, hollow.faces)) CHECK(b == 0);
  // Each would hold the other.
  CHECK(gone_boxes(hollow, 0.25).empty());
  CHECK(gone_boxes(collect({outer, inner}), 0.25).size() == 1);
  // Nothing is around it, or only what is open.
  CHECK(gone_boxes(collect({inside_out(inner), outer}), 0.25).empty());
  Heap open = hollow;
  open.faces.erase(open.faces.begin());
  CHECK(find_bodies(open.points, open.faces).back() == 11);
  // A solid in the cavity is a body; its own cavity is its own.
  const Heap nested = collect({outer, inside_out(inner), box({0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}),
                               inside_out(box({0.6, 0.6, 0.6}, {1.4, 1.4, 1.4}))});
  const auto body = find_bodies(nested.points, nested.faces);
  CHECK(body[12] == 0 && body[24] == 24 && body[36] == 24);
  // All of a hollow body goes together.
  const Heap twice = collect({box({0.1, 0.1, 0.1}, {1.9, 1.9, 1.9}), inside_out(box({0.2, 0.2, 0.2}, {1.8, 1.8, 1.8})),
                              outer, inside_out(box({0.05, 0.05, 0.05}, {1.95, 1.95, 1.95}))});
  CHECK((gone_boxes(twice, 0.25) == std::vector<Index>{0, 1}));
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
  RUN(a_panel_square_to_slabs_stays);
  RUN(small_and_narrow_bodies_need_nothing_parallel);
  RUN(a_face_of_45_degrees_is_parallel);
  RUN(an_inner_shell_belongs_to_its_body);
  RUN(points_too_near_to_tell_apart_are_no_obstacle);
  RUN(nothing_has_nothing_to_spare);
  return check::report();
}
