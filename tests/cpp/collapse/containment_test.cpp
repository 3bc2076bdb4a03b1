// The standing proof beside dense samples, while the faces that hold the surface keep changing.
#include <algorithm>
#include <vector>

#include "check.hpp"
#include "collapse/containment.hpp"
#include "mesh/certificate.hpp"
#include "shapes.hpp"

using namespace bldsimp;
using namespace shapes;

namespace {

std::vector<Index> all_of(const std::vector<Face>& faces) { return list_indices(faces.size()); }

std::vector<Index> faces_at(const std::vector<Face>& faces, Index point) {
  std::vector<Index> found;
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (has_corner(faces[f], point)) found.push_back(static_cast<Index>(f));
  return found;
}

std::vector<Holder> hold_by(const std::vector<Index>& slots, const std::vector<Face>& faces, Points points) {
  std::vector<Holder> holders;
  for (const Index slot : slots) {
    const auto [a, b, c] = corners_of(faces[slot], points);
    holders.push_back({slot, {a, b, c}});
  }
  return holders;
}

// How far samples of a surface are from faces.
double sample(const Soup& surface, const std::vector<Face>& faces, Points points, int steps) {
  std::vector<Vec3> places;
  for (const Face& face : surface.faces) {
    const auto [a, b, c] = corners_of(face, surface.points);
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; i + j <= steps; ++j)
        places.push_back((1 - double(i + j) / steps) * a + double(i) / steps * b + double(j) / steps * c);
  }
  return FaceTree(points, faces).farthest(places, 1e300);
}

// A triangle that a piece visits is part of the face that it is of, and all of them together are as large.
double visited_area(ContainmentProof& proof, const std::vector<Face>& faces) {
  double sum = 0;
  for (const Index slot : all_of(faces))
    proof.visit(slot, [&](const Triangle& piece) { sum += 0.5 * length(area_vector(piece)); });
  return sum;
}

double area_of(const Soup& soup) {
  double sum = 0;
  for (const Face& face : soup.faces) sum += 0.5 * length(area_vector(corners_of(face, soup.points)));
  return sum;
}

// Points of the holding faces move about; whatever is found is within the limit, and stays so.
void what_is_proven_is_within_the_limit_after_many_changes() {
  Random random(1);
  int accepted = 0, refused = 0;
  for (int round = 0; round < 60; ++round) {
    Soup soup = noisy_sheet(random, 4 + below(random, 4), 0.1, round % 3 == 0 ? 0.1 : 0.0);
    if (round % 2) rotate(soup, uniform(random, 0, 6));
    const double limit = std::array{0.02, 0.2, 0.6}[static_cast<std::size_t>(below(random, 3))];
    std::vector<Vec3> points(soup.points);
    const auto& faces = soup.faces;
    if (faces.empty()) continue;
    ContainmentProof proof(soup.points, faces, FaceTree(soup.points, faces).order(), points, faces, limit);
    CHECK(proof.unproven().empty());
    const double area = area_of(soup);
    for (int step = 0; step < 60; ++step) {
      const Index p = below(random, static_cast<Index>(points.size()));
      const auto old = faces_at(faces, p);
      if (old.empty()) continue;
      const Vec3 before = points[p];
      const double far = uniform(random, 0, 1.5 * limit);
      points[p] =
          soup.points[p] + Vec3{uniform(random, -far, far), uniform(random, -far, far), uniform(random, -far, far)};
      std::vector<Index> near(old);
      for (const Index f : old)
        for (const Index q : faces[f]) append(near, faces_at(faces, q));
      sort_unique(near);
      std::stable_partition(near.begin(), near.end(), [&](Index f) { return has_corner(faces[f], p); });
      const auto holders = hold_by(near, faces, points);
      if (!proof.finds(old, holders)) {
        ++refused;
        points[p] = before;
        continue;
      }
      ++accepted;
      proof.commit(old, holders);
    }
    CHECK(sample(soup, faces, points, 10) <= limit + 1e-12);
    CHECK(visited_area(proof, faces) <= area * (1 + 1e-9));
    for (const Index f : all_of(faces)) CHECK(proof.slot_of(f) >= 0);
  }
  CHECK(accepted > 500);
  CHECK(refused > 300);
}

// What was cut for a change is joined when the change is undone: the proof does not wear out.
void undone_changes_leave_nothing_behind() {
  Random random(2);
  const Soup soup = noisy_sheet(random, 6, 0.0, 0.0);
  const auto& faces = soup.faces;
  std::vector<Vec3> points(soup.points);
  ContainmentProof proof(soup.points, faces, FaceTree(soup.points, faces).order(), points, faces, 1e-3);
  const auto count = [&] {
    int pieces = 0;
    for (const Index slot : all_of(faces)) proof.visit(slot, [&](const Triangle&) { ++pieces; });
    return pieces;
  };
  CHECK(count() == static_cast<int>(faces.size()));
  int most = 0;
  for (int round = 0; round < 200; ++round) {
    const Index p = 7 + 6 * below(random, 4) + below(random, 4);
    const auto old = faces_at(faces, p);
    points[p] = soup.points[p] + Vec3{uniform(random, -0.4, 0.4), uniform(random, -0.4, 0.4), 0};
    auto holders = hold_by(old, faces, points);
    CHECK(proof.finds(old, holders));
    proof.commit(old, holders);
    most = std::max(most, count());
    points[p] = soup.points[p];
    holders = hold_by(old, faces, points);
    CHECK(proof.finds(old, holders));
    proof.commit(old, holders);
    CHECK(count() <= 2 * static_cast<int>(faces.size()));
  }
  CHECK(most > static_cast<int>(faces.size()));
}

// Long faces beside their other diagonals: a limit of a millionth asks for no more pieces than one of a hundredth.
void pieces_follow_the_edges_and_not_the_limit() {
  std::vector<Vec3> points;
  for (int i = 0; i <= 10; ++i)
    for (const double z : {0.0, 30.0}) points.push_back({10.0 * i, 0, z});
  std::vector<Face> surface, slots;
  for (Index i = 0; i < 20; i += 2) {
    surface.insert(surface.end(), {{i, i + 2, i + 3}, {i, i + 3, i + 1}});
    slots.insert(slots.end(), {{i, i + 2, i + 1}, {i + 2, i + 3, i + 1}});
  }
  std::vector<int> pieces;
  for (const double limit : {1e-1, 1e-3, 1e-5, 1e-7}) {
    ContainmentProof proof(points, surface, FaceTree(points, surface).order(), points, slots, limit);
    CHECK(proof.unproven().empty());
    pieces.push_back(0);
    for (const Index slot : all_of(slots)) proof.visit(slot, [&](const Triangle&) { ++pieces.back(); });
  }
  CHECK(*std::ranges::max_element(pieces) <= 4 * static_cast<int>(surface.size()));
}

void borders_are_held_as_faces_without_area() {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0.001, 0}, {2, 0, 0}, {5, 0, 0}};
  const std::vector<Face> border{{0, 1, 1}, {1, 2, 2}, {2, 3, 3}};
  for (const double limit : {0.0005, 0.002}) {
    ContainmentProof proof(points, border, all_of(border), points, border, limit);
    const std::vector<Index> old{0, 1};
    const std::vector<Holder> holders{{0, {points[0], points[2], points[2]}}};
    CHECK(proof.finds(old, holders) == (limit > 0.001));
  }
}

}  // namespace

int main() {
  RUN(what_is_proven_is_within_the_limit_after_many_changes);
  RUN(undone_changes_leave_nothing_behind);
  RUN(pieces_follow_the_edges_and_not_the_limit);
  RUN(borders_are_held_as_faces_without_area);
  return check::report();
}
