#include "planar/row_assignment.hpp"

#include <compare>
#include <unordered_map>

#include "mesh/errors.hpp"

namespace bldsimp {
namespace {

// The faces of unchanged facets, by their facets and points.
class UnchangedFaces {
 public:
  UnchangedFaces(Faces faces, Indices facet_of_face, Flags unchanged) {
    for (std::size_t f = 0; f < faces.size(); ++f)
      if (unchanged[facet_of_face[f]])
        sorted_.push_back({facet_of_face[f], least_first(faces[f]), static_cast<Index>(f)});
    std::sort(sorted_.begin(), sorted_.end());
  }

  // -1 where there is none.
  Index find(Index facet, const Face& triangle) const {
    const Entry wanted{facet, least_first(triangle), 0};
    const auto at = std::lower_bound(sorted_.begin(), sorted_.end(), wanted);
    return at != sorted_.end() && at->facet == facet && at->points == wanted.points ? at->face : -1;
  }

 private:
  struct Entry {
    Index facet;
    Face points;
    Index face;
    auto operator<=>(const Entry&) const = default;
  };

  static Face least_first(Face face) {
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    return face;
  }

  std::vector<Entry> sorted_;
};

}  // namespace

RowAssignment assign_rows(Faces triangles, Indices facet_of_triangle, Faces faces, const CornerRows& rows,
                          Indices facet_of_face, Indices group_of_facet, Indices part_of_facet, Flags unchanged,
                          Flags kept) {
  const auto key = [](Index facet, Index point) {
    return static_cast<std::uint64_t>(facet) << 32 | static_cast<std::uint32_t>(point);
  };
  const auto least_by = [&](auto group_of_face) {
    std::unordered_map<std::uint64_t, Index> least;
    least.reserve(2 * triangles.size());
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (int i = 0; i < 3; ++i) {
        const Index point = faces[f][i];
        if (!kept[point]) continue;
        const Index row = rows.at(static_cast<Index>(f), point);
        const auto [at, added] = least.try_emplace(key(group_of_face(f), point), row);
        if (!added) at->second = std::min(at->second, row);
      }
    return least;
  };
  const auto of_facet = least_by([&](std::size_t f) { return facet_of_face[f]; });
  std::unordered_map<std::uint64_t, Index> of_group, of_part;
  RowAssignment found{std::vector<Face>(triangles.size()), {}};
  const UnchangedFaces own(faces, facet_of_face, unchanged);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Index facet = facet_of_triangle[t], same = unchanged[facet] ? own.find(facet, triangles[t]) : -1;
    for (int i = 0; i < 3; ++i) {
      const Index point = triangles[t][i];
      Index& row = found.rows[t][i];
      if (same >= 0) {
        row = rows.at(same, point);
        continue;
      }
      if (const auto at = of_facet.find(key(facet, point)); at != of_facet.end()) {
        row = at->second;
        continue;
      }
      if (of_group.empty()) of_group = least_by([&](std::size_t f) { return group_of_facet[facet_of_face[f]]; });
      if (const auto at = of_group.find(key(group_of_facet[facet], point)); at != of_group.end()) {
        row = at->second;
        continue;
      }
      if (of_part.empty()) of_part = least_by([&](std::size_t f) { return part_of_facet[facet_of_face[f]]; });
      const auto at = of_part.find(key(part_of_facet[facet], point));
      if (at == of_part.end()) throw InternalError("assign_rows", "a corner is at no point of its part");
      row = at->second;
      found.foreign.push_back(static_cast<Index>(3 * t + i));
    }
  }
  return found;
}

}  // namespace bldsimp
