// Rows of corners: those of the facet, else of its group, else of its part; and what breaks this is told.
#include "planar/row_assignment.hpp"

#include "check.hpp"
#include "mesh/errors.hpp"
#include "planar/thin.hpp"

using namespace bldsimp;

namespace {

// Two triangles of each of three facets over the same four points, each facet with rows of its own.
struct Sheets {
  std::vector<Face> input{{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}, {8, 9, 10}, {8, 10, 11}};
  std::vector<Index> point_of_row{0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
  std::vector<Index> source{0, 1, 2, 3, 4, 5}, facet{0, 0, 1, 1, 2, 2};
  std::vector<Face> faces{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 2, 3}};

  RowAssignment assign(const std::vector<Face>& triangles, const std::vector<Index>& facets, std::vector<Index> group,
                       std::vector<Index> part, std::vector<std::uint8_t> unchanged = {0, 0, 0}) const {
    const std::vector<std::uint8_t> kept(4, 1);
    return assign_rows(triangles, facets, faces, {input, point_of_row, source, {}}, facet, group, part, unchanged,
                       kept);
  }
};

void corners_take_the_rows_of_their_facet() {
  const Sheets sheets;
  const auto found = sheets.assign({{1, 2, 3}, {0, 1, 3}, {3, 0, 1}}, {2, 1, 0}, {0, 0, 0}, {0, 0, 0});
  CHECK((found.rows == std::vector<Face>{{9, 10, 11}, {4, 5, 7}, {3, 0, 1}}));
  CHECK(found.foreign.empty());
}

void a_facet_without_the_point_takes_the_row_of_its_group_or_of_its_part() {
  Sheets sheets;
  // The second facet loses the face at point 3.
  for (auto* list : {&sheets.source, &sheets.facet}) list->erase(list->begin() + 3);
  sheets.faces.erase(sheets.faces.begin() + 3);
  const auto grouped = sheets.assign({{1, 2, 3}}, {1}, {0, 1, 1}, {0, 0, 0});
  CHECK((grouped.rows == std::vector<Face>{{5, 6, 11}}) && grouped.foreign.empty());
  const auto parted = sheets.assign({{1, 2, 3}}, {1}, {0, 1, 2}, {0, 0, 0});
  CHECK((parted.rows == std::vector<Face>{{5, 6, 3}}) && (parted.foreign == std::vector<Index>{2}));
}

void faces_of_unchanged_facets_keep_their_rows() {
  Sheets sheets;
  // Both faces of the first facet have rows of their own at the point that they share.
  sheets.input[1] = {12, 13, 14};
  sheets.point_of_row.insert(sheets.point_of_row.end(), {0, 2, 3});
  const std::vector<Face> own{{2, 3, 0}};
  CHECK((sheets.assign(own, {0}, {0, 0, 0}, {0, 0, 0}, {1, 1, 1}).rows == std::vector<Face>{{13, 14, 12}}));
  CHECK((sheets.assign(own, {0}, {0, 0, 0}, {0, 0, 0}).rows == std::vector<Face>{{2, 14, 0}}));
}

template <class Run>
std::string error_of(Run run) {
  try {
    run();
  } catch (const InternalError& error) {
    return error.what();
  }
  return "none";
}

void broken_invariants_name_their_stage() {
  Sheets sheets;
  for (auto* list : {&sheets.source, &sheets.facet}) list->erase(list->begin() + 3);
  sheets.faces.erase(sheets.faces.begin() + 3);
  CHECK(error_of([&] { sheets.assign({{1, 2, 3}}, {1}, {0, 1, 2}, {0, 1, 2}); }) ==
        "assign_rows: a corner is at no point of its part");
  Outlines outlines;
  outlines.chain_start = {0, 3};
  outlines.chain_points = {0, 1, 2};
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const std::vector<std::uint8_t> both{1, 0, 1}, first{1, 1, 0};
  CHECK(lay_pieces(points, outlines, both).size() == 1);
  CHECK(error_of([&] { lay_pieces(points, outlines, first); }) == "lay_pieces: an end of a chain is not kept");
}

}  // namespace

int main() {
  RUN(corners_take_the_rows_of_their_facet);
  RUN(a_facet_without_the_point_takes_the_row_of_its_group_or_of_its_part);
  RUN(faces_of_unchanged_facets_keep_their_rows);
  RUN(broken_invariants_name_their_stage);
  return check::report();
}
