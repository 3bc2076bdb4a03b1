// The edges of a mesh, each with the halfedges on it: the loop that pairing and orienting share.
#pragma once

#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

#include "vec3.hpp"

namespace bldsimp {

inline Index origin(std::span<const Face> faces, Index h) { return faces[h / 3][h % 3]; }
inline Index target(std::span<const Face> faces, Index h) { return faces[h / 3][next_halfedge(h) % 3]; }
inline Index apex(std::span<const Face> faces, Index h) { return faces[h / 3][previous_halfedge(h) % 3]; }

// Calls visit(span of halfedges) for each edge, by its lower and then its upper end; the halfedges of an
// edge come in rising order. Buckets by the lower end are small, so this is nearly linear.
template <class Visit>
void for_each_edge(std::span<const Face> faces, Index point_count, Visit visit) {
  const Index count = static_cast<Index>(3 * faces.size());
  const auto lower = [&](Index h) { return std::min(origin(faces, h), target(faces, h)); };
  const auto upper = [&](Index h) { return std::max(origin(faces, h), target(faces, h)); };
  std::vector<Index> start(point_count + 1, 0), bucketed(count);
  for (Index h = 0; h < count; ++h) ++start[lower(h) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  for (Index h = 0; h < count; ++h) bucketed[start[lower(h)]++] = h;  // start now holds the ends
  std::vector<std::pair<Index, Index>> bucket;
  std::vector<Index> edge;
  Index from = 0;
  for (Index p = 0; p < point_count; ++p) {
    bucket.clear();
    for (; from < start[p]; ++from) bucket.push_back({upper(bucketed[from]), bucketed[from]});
    std::sort(bucket.begin(), bucket.end());
    for (std::size_t i = 0; i < bucket.size();) {
      edge.clear();
      const Index end = bucket[i].first;
      for (; i < bucket.size() && bucket[i].first == end; ++i) edge.push_back(bucket[i].second);
      visit(std::span<const Index>(edge));
    }
  }
}

}  // namespace bldsimp
