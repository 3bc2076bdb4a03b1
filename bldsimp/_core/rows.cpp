#include "rows.hpp"

#include <algorithm>
#include <unordered_map>

namespace bldsimp {

std::vector<Face> find_rows(std::span<const Face> triangles, std::span<const Index> facet_of_triangle,
                            std::span<const Face> faces, const Rows& rows,
                            std::span<const Index> facet_of_face, std::span<const std::uint8_t> kept) {
  const auto key = [](Index facet, Index point) {
    return static_cast<std::uint64_t>(facet) << 32 | static_cast<std::uint32_t>(point);
  };
  std::unordered_map<std::uint64_t, Index> least;
  least.reserve(2 * triangles.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int i = 0; i < 3; ++i) {
      const Index point = faces[f][i];
      if (!kept[point]) continue;
      const Index row = rows.at(static_cast<Index>(f), point);
      const auto [at, added] = least.try_emplace(key(facet_of_face[f], point), row);
      if (!added) at->second = std::min(at->second, row);
    }
  std::vector<Face> result(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int i = 0; i < 3; ++i) result[t][i] = least.at(key(facet_of_triangle[t], triangles[t][i]));
  return result;
}

}  // namespace bldsimp
