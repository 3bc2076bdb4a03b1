// Large flat facets keep their planes: which ones, and that collapses leave them there.
#include "collapse/held_facets.hpp"

#include "cells.hpp"
#include "check.hpp"
#include "collapse/collapse.hpp"

using namespace bldsimp;
using shapes::Random;
using shapes::Soup;

namespace {

// A point stays this near a plane that is held, as a share of the tolerance.
constexpr double kNear = 0.06;

HeldFacets held_of(const Soup& soup, double tolerance) {
  return find_held_facets(soup.points, soup.faces, std::vector<Index>(soup.faces.size(), 0), tolerance);
}

// Faces that are held, of which each lies in its plane.
std::ptrdiff_t count_held(const Soup& soup, double tolerance) {
  const HeldFacets held = held_of(soup, tolerance);
  CHECK(held.plane_of_face.size() == soup.faces.size());
  for (std::size_t f = 0; f < soup.faces.size(); ++f) {
    const Index plane = held.plane_of_face[f];
    CHECK(-1 <= plane && plane < std::ssize(held.planes));
    if (plane < 0) continue;
    const auto& [normal, offset] = held.planes[plane];
    CHECK(std::abs(length(normal) - 1) < 1e-12);
    CHECK(dot(normal, area_vector(corners_of(soup.faces[f], soup.points))) > 0);
    for (const Index p : soup.faces[f]) CHECK(std::abs(dot(normal, soup.points[p]) - offset) <= kNear * tolerance);
  }
  return std::count_if(held.plane_of_face.begin(), held.plane_of_face.end(), [](Index k) { return k >= 0; });
}

Soup far_away(Soup soup) {
  for (Vec3& p : soup.points) p = p + Vec3{1e5, -2e5, 300};
  return soup;
}

void the_walls_of_a_large_box_are_held() {
  const Soup box = shapes::box({0, 0, 0}, {10, 8, 6});
  CHECK(count_held(box, 0.3) == 12);
  CHECK(count_held(far_away(box), 0.3) == 12);
  CHECK(held_of(box, 0.3).planes.size() == 6);
  Soup turned = box;
  shapes::rotate(turned, 0.7);
  CHECK(count_held(turned, 0.3) == 12);
}

void what_is_small_beside_the_tolerance_is_not() { CHECK(count_held(shapes::box({0, 0, 0}, {1, 1, 1}), 1) == 0); }

void a_flat_sheet_is_held_by_its_open_edges() {
  Random random(1);
  CHECK(count_held(shapes::noisy_sheet(random, 12, 0, 0), 0.5) == 2 * 11 * 11);
}

void noise_is_not_held() {
  Random random(2);
  CHECK(count_held(shapes::noisy_sheet(random, 12, 0.3, 0), 0.5) == 0);
}

void reveals_beside_a_wall_are_held() {
  shapes::Cells cells = shapes::wall(1, 1, 0.5, {3, 7}, {2, 6});
  cells.fill({1, 1, 1}, {2, 2, 2}, false);
  const Soup soup = cells.surface();
  const HeldFacets held = held_of(soup, 0.3);
  Index reveals = 0;
  for (std::size_t f = 0; f < soup.faces.size(); ++f) {
    const Vec3 middle = centroid(corners_of(soup.faces[f], soup.points));
    const bool inside = middle.x >= 3 && middle.x <= 7 && middle.z >= 2 && middle.z <= 6;
    if (inside) ++reveals, CHECK(held.plane_of_face[f] >= 0);
  }
  CHECK(reveals == 8);
}

// More faces than points, and a component of one face.
void faces_are_noticed_by_their_share_of_a_component() {
  Soup soup = shapes::box({0, 0, 0}, {10, 8, 6});
  for (int i = 0; i < 12; ++i) soup.faces.push_back(soup.faces[i]);
  const auto count = static_cast<Index>(soup.points.size());
  for (const Vec3 p : {Vec3{0, -20, 0}, Vec3{10, -20, 0}, Vec3{5, -20, 6}}) soup.points.push_back(p);
  soup.faces.push_back({count, count + 1, count + 2});
  const HeldFacets held = held_of(soup, 0.3);
  for (std::size_t f = 0; f < 24; ++f) CHECK(std::abs(held.noticed[f] - 1e-3 * 2 * 376) < 1e-9);
  CHECK(std::abs(held.noticed[24] - 1e-3 * 30) < 1e-9);
}

void nothing_holds_nothing() {
  const HeldFacets held = find_held_facets({}, {}, {}, 1);
  CHECK(held.plane_of_face.empty() && held.planes.empty());
}

// What a collapse leaves of the faces that are held lies where they did.
void collapses_leave_walls_in_their_planes() {
  Random random(3);
  std::ptrdiff_t all = 0;
  for (int round = 0; round < 30; ++round) {
    Soup soup = shapes::block_with_features(random, 0.6, 1 + round % 4);
    if (soup.faces.empty()) continue;
    if (round % 3 == 1) shapes::rotate(soup, 0.3);
    if (round % 3 == 2) shapes::add_noise(random, soup, 1e-3);
    const double tolerance = shapes::uniform(random, 0.2, 0.6);
    const HeldFacets held = held_of(soup, tolerance);
    const std::vector<Index> label(soup.faces.size(), 0);
    const std::vector<std::uint8_t> none(soup.faces.size(), 0);
    const auto result = collapse({soup.points, soup.faces, label, none, none, 0, tolerance, 6, false, nullptr});
    for (std::size_t t = 0; t < result.triangles.size(); ++t) {
      const Index plane = held.plane_of_face[result.source[t]];
      if (plane < 0) continue;
      ++all;
      for (const Index p : result.triangles[t])
        CHECK(std::abs(dot(held.planes[plane].normal, result.points[p]) - held.planes[plane].offset) <=
              kNear * tolerance + 1e-6);
    }
  }
  CHECK(all > 100);
}

}  // namespace

int main() {
  RUN(the_walls_of_a_large_box_are_held);
  RUN(what_is_small_beside_the_tolerance_is_not);
  RUN(a_flat_sheet_is_held_by_its_open_edges);
  RUN(noise_is_not_held);
  RUN(reveals_beside_a_wall_are_held);
  RUN(faces_are_noticed_by_their_share_of_a_component);
  RUN(nothing_holds_nothing);
  RUN(collapses_leave_walls_in_their_planes);
  return check::report();
}
