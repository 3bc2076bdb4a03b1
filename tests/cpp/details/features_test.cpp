// Remove features of walls and of open sheets: what goes, what stays, and that everything stays closed.
#include "details/features.hpp"

#include "cells.hpp"
#include "check.hpp"

using namespace bldsimp;
using shapes::Cells;
using shapes::Soup;

namespace {

using FlagList = std::vector<std::uint8_t>;

constexpr Index kMany = 1 << 20;

// One part for all faces.
std::vector<Index> zeros(const std::vector<Index>& label) { return std::vector<Index>(label.size(), 0); }
FlagList many_rows(const Soup& soup) { return FlagList(soup.points.size(), 1); }

// A mesh, and what `remove_features` makes of it.
struct Removal {
  Soup soup;
  std::vector<Index> label;
  FlagList stays;
  int decimals = 6;
  FeatureRemoval result = {};

  explicit Removal(Soup given) : soup(std::move(given)), label(soup.faces.size(), 0), stays(soup.faces.size(), 0) {}

  Removal& run(double limit) {
    const FlagList none(soup.faces.size(), 0);
    result = remove_features({soup.points,
                              soup.faces,
                              label,
                              zeros(label),
                              many_rows(soup),
                              stays,
                              none,
                              limit,
                              1e-4,
                              {decimals, false},
                              false,
                              kMany});
    return *this;
  }
  std::vector<Face> faces() const {
    std::vector<Face> all(result.faces);
    for (std::size_t f = 0; f < soup.faces.size(); ++f)
      if (!result.left_out[f]) all.push_back(soup.faces[f]);
    return all;
  }
  IndexPair edges() const { return count_edges(faces(), static_cast<Index>(result.points.size())); }
  bool changes_nothing() const {
    return result.kinds.empty() && result.faces.empty() && result.points == soup.points &&
           std::count(result.left_out.begin(), result.left_out.end(), 0) == std::ssize(result.left_out);
  }
};

// Whether one feature went: of a kind, with so many triangles.
bool went(const Removal& removal, FeatureKind kind, Index triangles) {
  return removal.result.kinds == FlagList{static_cast<std::uint8_t>(kind)} &&
         removal.result.triangles == std::vector<Index>{triangles};
}

Soup recess(double depth = 0.5) {
  Cells cells = shapes::wall(2, depth, 0.5, {4, 6}, {3, 5});
  cells.fill({1, 1, 1}, {2, 2, 2}, false);
  return cells.surface();
}

Soup passage() {
  Cells cells = shapes::wall(1, 1, 0.5, {4, 5}, {3, 6});
  cells.fill({1, 1, 1}, {2, 2, 2}, false);
  return cells.surface();
}

// A sheet of 10 x 8 with a hole of 1 x 3.
Soup sheet_with_hole() {
  Soup soup;
  for (const double y : {0, 3, 6, 8})
    for (const double x : {0, 4, 5, 10}) soup.add({x, y, 0});
  for (Index y = 0; y < 3; ++y)
    for (Index x = 0; x < 3; ++x)
      if (x != 1 || y != 1) soup.add_quad(4 * y + x, 4 * y + x + 1, 4 * y + x + 5, 4 * y + x + 4);
  return soup;
}

void a_recess_goes_where_its_depth_is_within_the_limit() {
  const Removal gone = Removal(recess()).run(0.6);
  CHECK(went(gone, FeatureKind::detail, 10));
  CHECK(gone.result.boxes == (std::vector<Vec3>{{4, 0, 3}, {6, 0.5, 5}}));
  CHECK(gone.edges() == (IndexPair{0, 0}));
  for (const Face& f : gone.faces())
    for (const Index p : f)
      CHECK(gone.result.points[p].y != 0.5 || gone.result.points[p].x == 0 || gone.result.points[p].x == 10 ||
            gone.result.points[p].z == 0 || gone.result.points[p].z == 8);
  CHECK(Removal(recess()).run(0.4).changes_nothing());
}

void a_passage_goes_where_its_half_width_is_within_the_limit() {
  const Removal gone = Removal(passage()).run(0.6);
  CHECK(went(gone, FeatureKind::passage, 8));
  CHECK(gone.edges() == (IndexPair{0, 0}));
  CHECK(Removal(passage()).run(0.4).changes_nothing());
}

void a_sill_goes() {
  Cells cells = shapes::wall(2, 2, 0.5, {4, 6}, {3, 5});
  cells.fill({1, 0, 1}, {2, 1, 2}, true);
  const Removal gone = Removal(cells.surface()).run(0.6);
  CHECK(went(gone, FeatureKind::detail, 10));
  CHECK(gone.edges() == (IndexPair{0, 0}));
  CHECK(Removal(cells.surface()).run(0.4).changes_nothing());
}

void a_hole_of_a_sheet_is_closed_and_its_rim_stays() {
  const Removal gone = Removal(sheet_with_hole()).run(0.6);
  CHECK(went(gone, FeatureKind::boundary_loop, 0));
  CHECK(gone.edges() == (IndexPair{12, 0}));
  CHECK(Removal(sheet_with_hole()).run(0.4).changes_nothing());
}

void what_must_stay_stays() {
  Removal pinned(recess());
  for (std::size_t f = 0; f < pinned.soup.faces.size(); ++f)
    pinned.stays[f] = pinned.soup.points[pinned.soup.faces[f][0]].y == 0.5 &&
                      pinned.soup.points[pinned.soup.faces[f][1]].y == 0.5 &&
                      pinned.soup.points[pinned.soup.faces[f][2]].y == 0.5;
  CHECK(std::count(pinned.stays.begin(), pinned.stays.end(), 1) == 2);
  CHECK(pinned.run(0.6).changes_nothing());
}

void a_label_keeps_its_last_face() {
  Removal labeled(recess());
  for (std::size_t f = 0; f < labeled.soup.faces.size(); ++f) {
    const Triangle at = corners_of(labeled.soup.faces[f], labeled.soup.points);
    labeled.label[f] = at[0].y == 0.5 && at[1].y == 0.5 && at[2].y == 0.5;
  }
  CHECK(labeled.run(0.6).changes_nothing());
  // Where it has more elsewhere, too: it is wider than twice the limit.
  for (std::size_t f = 0; f < labeled.soup.faces.size(); ++f)
    if (centroid(corners_of(labeled.soup.faces[f], labeled.soup.points)).y == 2) labeled.label[f] = 1;
  CHECK(labeled.run(0.6).changes_nothing());
}

void a_label_keeps_its_last_face_where_two_features_go_at_once() {
  Cells cells(
      {std::vector<double>{0, 2, 3, 7, 8, 10}, std::vector<double>{0, 0.5, 2}, std::vector<double>{0, 3, 5, 8}});
  cells.fill({0, 0, 0}, {5, 2, 3}, true);
  cells.fill({1, 0, 1}, {2, 1, 2}, false);
  cells.fill({3, 0, 1}, {4, 1, 2}, false);
  Removal labeled(cells.surface());
  for (std::size_t f = 0; f < labeled.soup.faces.size(); ++f) {
    const Triangle at = corners_of(labeled.soup.faces[f], labeled.soup.points);
    labeled.label[f] = at[0].y == 0.5 && at[1].y == 0.5 && at[2].y == 0.5;
  }
  CHECK(std::count(labeled.label.begin(), labeled.label.end(), 1) == 4);
  labeled.run(0.6);
  std::ptrdiff_t left = 0;
  for (std::size_t f = 0; f < labeled.label.size(); ++f) left += labeled.label[f] && !labeled.result.left_out[f];
  for (const Index parent : labeled.result.parent) left += labeled.label[parent];
  CHECK(left > 0);
}

// A frame that is painted round a recess, 3 wide: where the recess goes the paint stays.
void paint_round_a_recess_stays() {
  Cells cells({std::vector<double>{0, 1, 4, 5, 8, 10}, std::vector<double>{0, 0.5, 2},
               std::vector<double>{0, 1, 3.5, 4.5, 7, 8}});
  cells.fill({0, 0, 0}, {5, 2, 5}, true);
  cells.fill({2, 0, 2}, {3, 1, 3}, false);
  Removal labeled(cells.surface());
  double before = 0, after = 0;
  const auto area = [&](const Face& f) { return length(area_vector(corners_of(f, labeled.soup.points))) / 2; };
  for (std::size_t f = 0; f < labeled.soup.faces.size(); ++f) {
    const Vec3 at = centroid(corners_of(labeled.soup.faces[f], labeled.soup.points));
    const bool in_frame = at.y == 0 && at.x > 1 && at.x < 8 && at.z > 1 && at.z < 7;
    labeled.label[f] = in_frame || at.y == 2;  // and the wall's back
    if (in_frame) before += area(labeled.soup.faces[f]);
  }
  labeled.run(0.6);
  for (std::size_t f = 0; f < labeled.label.size(); ++f) {
    const double y = centroid(corners_of(labeled.soup.faces[f], labeled.soup.points)).y;
    if (!labeled.result.left_out[f] && labeled.label[f] && y == 0) after += area(labeled.soup.faces[f]);
  }
  for (std::size_t c = 0; c < labeled.result.faces.size(); ++c)
    if (labeled.label[labeled.result.parent[c]]) after += area(labeled.result.faces[c]);
  CHECK(after >= before - 1e-9);
}

void an_opening_between_two_labels_stays() {
  Cells cells({std::vector<double>{0, 4, 4.5, 5, 10}, std::vector<double>{0, 1}, std::vector<double>{0, 3, 6, 8}});
  cells.fill({0, 0, 0}, {4, 1, 3}, true);
  cells.fill({1, 0, 1}, {3, 1, 2}, false);
  Removal labeled(cells.surface());
  for (std::size_t f = 0; f < labeled.soup.faces.size(); ++f)
    labeled.label[f] = centroid(corners_of(labeled.soup.faces[f], labeled.soup.points)).x > 4.5;
  CHECK(labeled.run(0.6).changes_nothing());
}

void a_corner_that_was_bitten_off_comes_back_where_points_may_move() {
  Cells cells = shapes::wall(2, 0.5, 0.5, {4, 9.5}, {3, 7.5});
  cells.fill({2, 1, 2}, {3, 2, 3}, false);
  Removal gone = Removal(cells.surface());
  gone.run(0.6);
  CHECK(gone.result.kinds.size() == 1);
  CHECK(gone.edges() == (IndexPair{0, 0}));
  const auto points = gone.result.points;
  CHECK(std::any_of(points.begin(), points.end(), [](Vec3 p) { return p == Vec3{10, 0, 8}; }));
  gone.decimals = -1;
  CHECK(gone.run(0.6).result.points == gone.soup.points);
}

void what_has_gone_already_does_not_come_back() {
  Soup soup = recess();
  const std::vector<Index> label(soup.faces.size() + 12, 0);
  const FlagList stays(label.size(), 0);
  FlagList left_out(soup.faces.size(), 0);
  left_out.resize(label.size(), 1);
  shapes::append(soup, shapes::box({1, -0.1, 1}, {2, 0, 2}), {0, 0, 0});
  const auto result = remove_features({soup.points,
                                       soup.faces,
                                       label,
                                       zeros(label),
                                       many_rows(soup),
                                       stays,
                                       left_out,
                                       0.6,
                                       1e-4,
                                       {6, false},
                                       false,
                                       kMany});
  CHECK(result.kinds.size() == 1);
  for (std::size_t f = label.size() - 12; f < label.size(); ++f) CHECK(result.left_out[f]);
}

void nothing_has_no_features() {
  const auto result = remove_features({{}, {}, {}, {}, {}, {}, {}, 1, 1e-4, {6, false}, false, kMany});
  CHECK(result.faces.empty() && result.points.empty() && result.kinds.empty());
  CHECK(Removal(shapes::box({0, 0, 0}, {4, 3, 2})).run(0.1).changes_nothing());
}

}  // namespace

int main() {
  RUN(a_recess_goes_where_its_depth_is_within_the_limit);
  RUN(a_passage_goes_where_its_half_width_is_within_the_limit);
  RUN(a_sill_goes);
  RUN(a_hole_of_a_sheet_is_closed_and_its_rim_stays);
  RUN(what_must_stay_stays);
  RUN(a_label_keeps_its_last_face);
  RUN(a_label_keeps_its_last_face_where_two_features_go_at_once);
  RUN(paint_round_a_recess_stays);
  RUN(an_opening_between_two_labels_stays);
  RUN(a_corner_that_was_bitten_off_comes_back_where_points_may_move);
  RUN(what_has_gone_already_does_not_come_back);
  RUN(nothing_has_no_features);
  return check::report();
}
