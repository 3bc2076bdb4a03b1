// Orientation: neighbors agree, closed components face outwards, cavities inwards, and what has no sides stays.
#include "mesh/orient.hpp"

#include "check.hpp"
#include "mesh/weld.hpp"
#include "shapes.hpp"

using namespace bldsimp;
using shapes::Random;
using shapes::Soup;

namespace {

// Faces as their soup has them, after turning what is told to turn.
std::vector<Face> orient(const Soup& soup, const std::vector<std::uint8_t>& fixed = {}) {
  std::vector<Face> faces(soup.faces);
  const Halfedges halfedges = pair_halfedges(soup.points, faces, {}, 0);
  const std::vector<std::uint8_t> none(faces.size(), 0);
  for (const Index f : find_misoriented(soup.points, faces, halfedges, {}, fixed.empty() ? none : fixed))
    std::swap(faces[f][1], faces[f][2]);
  return faces;
}

double volume(const Soup& soup, std::span<const Face> faces) {
  double sum = 0;
  for (const auto& [a, b, c] : faces) sum += dot(soup.points[a], cross(soup.points[b], soup.points[c])) / 6;
  return sum;
}

// As many halfedges of each edge run one way as the other.
bool is_balanced(std::span<const Face> faces) {
  std::vector<Edge> forward, back;
  for (const Face& f : faces)
    for (int i = 0; i < 3; ++i) {
      forward.push_back({f[i], f[(i + 1) % 3]});
      back.push_back({f[(i + 1) % 3], f[i]});
    }
  std::sort(forward.begin(), forward.end());
  std::sort(back.begin(), back.end());
  return forward == back;
}

void turned_faces_of_a_box_turn_back() {
  Random random(1);
  for (int round = 0; round < 50; ++round) {
    Soup soup = shapes::box({-1, 2, 5}, {3, 4, 6});
    const auto right = soup.faces;
    shapes::turn_some(random, soup, 0.02 * round);
    CHECK(orient(soup) == right);
  }
}

void blocks_come_to_enclose_their_own_volume() {
  Random random(2);
  for (int round = 0; round < 30; ++round) {
    // Without diagonal neighbors each edge has two faces, so that all sides are told.
    Soup soup = shapes::block_with_windows(random, 4, 0, 1);
    const double before = volume(soup, soup.faces);
    shapes::turn_some(random, soup, 0.4);
    shapes::rotate(soup, round);
    const auto faces = orient(soup);
    CHECK(is_balanced(faces));
    CHECK(std::abs(volume(soup, faces) - before) < 1e-9);
  }
}

void cavities_face_inwards() {
  Soup soup = shapes::box({0, 0, 0}, {9, 9, 9});
  const Soup inner = shapes::box({3, 3, 3}, {6, 6, 6}), innermost = shapes::box({4, 4, 4}, {5, 5, 5});
  shapes::append(soup, inner, {0, 0, 0});
  for (std::size_t f = 12; f < 24; ++f) std::swap(soup.faces[f][1], soup.faces[f][2]);
  shapes::append(soup, innermost, {0, 0, 0});
  CHECK(orient(soup) == soup.faces);
  for (std::size_t f = 24; f < 36; ++f) std::swap(soup.faces[f][1], soup.faces[f][2]);
  const auto faces = orient(soup);
  CHECK(std::abs(volume(soup, faces) - (729 - 27 + 1)) < 1e-9);
}

void fixed_components_stay() {
  Soup soup = shapes::box({0, 0, 0}, {1, 1, 1});
  for (Face& face : soup.faces) std::swap(face[1], face[2]);
  std::vector<std::uint8_t> fixed(12, 0);
  fixed[5] = 1;
  CHECK(orient(soup, fixed) == soup.faces);
  CHECK(orient(soup) != soup.faces);
}

void a_moebius_strip_stays() {
  Soup soup;
  constexpr Index count = 9;
  for (Index i = 0; i < count; ++i) {
    const double turn = 2 * 3.14159265358979 * i / count;
    for (const double side : {-0.3, 0.3}) {
      const double r = 1 + side * std::cos(turn / 2);
      soup.add({r * std::cos(turn), r * std::sin(turn), side * std::sin(turn / 2)});
    }
  }
  for (Index i = 0; i < count; ++i) {
    const bool last = i + 1 == count;
    const Index a = 2 * i, b = 2 * i + 1, c = last ? 0 : 2 * i + 3, d = last ? 1 : 2 * i + 2;
    soup.add_quad(a, b, c, d);
  }
  CHECK(orient(soup) == soup.faces);
}

}  // namespace

int main() {
  RUN(turned_faces_of_a_box_turn_back);
  RUN(blocks_come_to_enclose_their_own_volume);
  RUN(cavities_face_inwards);
  RUN(fixed_components_stay);
  RUN(a_moebius_strip_stays);
  return check::report();
}
