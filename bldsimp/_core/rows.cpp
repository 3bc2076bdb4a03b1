#include "rows.hpp"

#include <algorithm>
#include <unordered_map>

namespace bldsimp {

std::vector<Face> find_rows(std::span<const Face> triangles, std::span<const Index> facet_of_triangle,
                            std::span<const Face> faces, const Rows& rows,
                            std::span<const Index> facet_of_face, std::span<const Index> part_of_facet,
                            std::span<const std::uint8_t> kept) {
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
  std::unordered_map<std::uint64_t, Index> of_part;
  std::vector<Face> result(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      const Index facet = facet_of_triangle[t], point = triangles[t][i];
      if (const auto at = of_facet.find(key(facet, point)); at != of_facet.end()) {
        result[t][i] = at->second;
        continue;
      }
      if (of_part.empty()) of_part = least_by([&](std::size_t f) { return part_of_facet[facet_of_face[f]]; });
      result[t][i] = of_part.at(key(part_of_facet[facet], point));
    }
  return result;
}

}  // namespace bldsimp
