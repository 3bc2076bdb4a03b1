// A triangle leans if walls are near it and none of them is parallel.
#include "collapse/walls.hpp"

#include "cells.hpp"
#include "check.hpp"

using namespace bldsimp;
using shapes::Soup;

namespace {

constexpr double kTolerance = 0.3;

// A box of 10 x 8 x 6, whose wall y = 0 faces the triangles below.
struct Block {
  Soup soup = shapes::box({0, 0, 0}, {10, 8, 6});
  HeldFacets held;
  Walls walls;

  explicit Block(Vec3 away = {0, 0, 0}) : held(hold(away)), walls(soup.points, soup.faces, held.flat, kTolerance) {}

  HeldFacets hold(Vec3 away) {
    for (Vec3& p : soup.points) p = p + away;
    return find_held_facets(soup.points, soup.faces, std::vector<Index>(soup.faces.size(), 0), kTolerance);
  }
};

// Beside the middle of that wall, a size large, its upper edge in front of its lower one by `out`.
Triangle beside_wall(double size, double out, double away = 0.1) {
  return {{{5 - size, -away, 3 - size}, {5 + size, -away, 3 - size}, {5, -away - out, 3 + size}}};
}

void all_faces_of_a_box_tell_what_leans() { CHECK(Block().held.flat.size() == 12); }

void a_triangle_leans_unless_it_is_parallel() {
  const Block block;
  CHECK(!block.walls.measure_leaning(beside_wall(2, 0), {}));
  CHECK(!block.walls.measure_leaning(beside_wall(2, 0.02), {}));
  const auto near = block.walls.measure_leaning(beside_wall(2, 0.2), {});
  CHECK(near && std::abs(*near - (0.1 + 0.2 / 3)) < 1e-12);
  CHECK(block.walls.measure_leaning(beside_wall(2, -0.2), {}).has_value());
}

void the_origin_is_added() {
  const Vec3 away{1e4, -2e4, 50};
  const Block block(away);
  CHECK(block.walls.measure_leaning(beside_wall(2, 0.2), away).has_value());
  CHECK(!block.walls.measure_leaning(beside_wall(2, 0), away));
  CHECK(!block.walls.measure_leaning(beside_wall(2, 0.2), {}));
}

void what_is_far_from_all_walls_may_lean() { CHECK(!Block().walls.measure_leaning(beside_wall(2, 0.2, 0.5), {})); }

void a_triangle_across_a_corner_follows_either_wall() {
  const Block block;
  // Parallel to the floor, and as near to the wall.
  CHECK(!block.walls.measure_leaning({{{3, -0.1, 0.1}, {7, -0.1, 0.1}, {5, 2, 0.1}}}, {}));
  // It cuts the corner off.
  CHECK(block.walls.measure_leaning({{{3, -0.1, 0.6}, {7, -0.1, 0.6}, {5, 0.6, -0.1}}}, {}).has_value());
}

void without_walls_nothing_leans() {
  const Block block;
  CHECK(!Walls(block.soup.points, block.soup.faces, {}, kTolerance).measure_leaning(beside_wall(2, 0.2), {}));
  CHECK(!Walls({}, {}, {}, kTolerance).measure_leaning(beside_wall(2, 0.2), {}));
}

}  // namespace

int main() {
  RUN(all_faces_of_a_box_tell_what_leans);
  RUN(a_triangle_leans_unless_it_is_parallel);
  RUN(the_origin_is_added);
  RUN(what_is_far_from_all_walls_may_lean);
  RUN(a_triangle_across_a_corner_follows_either_wall);
  RUN(without_walls_nothing_leans);
  return check::report();
}
