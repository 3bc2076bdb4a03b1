// Tell which triangles a vertical ray crosses, and which way, whatever lies in one plane.
#pragma once

#include "mesh/box_tree.hpp"
#include "mesh/predicates.hpp"

namespace bldsimp {

// On which side of a-b, seen along z, p is once it is moved by an infinitesimal in x and a smaller one in y;
// 0 only where a and b are one point there.
inline int side_of(Vec3 a, Vec3 b, Vec3 p) {
  if (const int side = orient2d({a.x, a.y}, {b.x, b.y}, {p.x, p.y}); side != 0) return side;
  if (a.y != b.y) return a.y > b.y ? 1 : -1;
  return a.x != b.x ? (b.x > a.x ? 1 : -1) : 0;
}

// Whether a ray upwards from p, moved so, crosses a triangle: 1 from below (the side that it does not face),
// -1 from above. Of p on the triangle itself, moved upwards before all else, it does not.
inline int crosses_above(Vec3 p, const Triangle& triangle) {
  const auto& [a, b, c] = triangle;
  const int side = side_of(a, b, p);
  if (side == 0 || side_of(b, c, p) != side || side_of(c, a, p) != side) return 0;
  return orient3d(a, b, c, p) == side ? side : 0;
}

// Calls visit(face, way) for the faces of a tree that such a ray crosses.
template <class Visit>
void visit_above(Vec3 p, const BoxTree& tree, Points points, Faces faces, Visit visit) {
  const auto above = [&](const Box& box) {
    return box.low.x <= p.x && p.x <= box.high.x && box.low.y <= p.y && p.y <= box.high.y && p.z <= box.high.z;
  };
  tree.visit(p, above, [&](Index i) {
    const Index face = tree.order()[i];
    if (const int way = crosses_above(p, corners_of(faces[face], points)); way != 0) visit(face, way);
  });
}

// Calls visit(item) for those whose numbers do not add up to 0.
template <class Visit>
void for_unbalanced(std::vector<std::pair<Index, int>>& numbers, Visit visit) {
  std::sort(numbers.begin(), numbers.end());
  for_runs(
      numbers, [](const auto& a, const auto& b) { return a.first == b.first; },
      [&](auto own) {
        int sum = 0;
        for (const auto& [item, number] : own) sum += number;
        if (sum != 0) visit(own[0].first);
      });
}

}  // namespace bldsimp
