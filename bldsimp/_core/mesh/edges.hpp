// Visit the edges of a mesh, each with the halfedges on it.
#pragma once

#include "mesh/vec3.hpp"

namespace bldsimp {

inline Index origin(Faces faces, Index h) { return faces[h / 3][h % 3]; }
inline Index target(Faces faces, Index h) { return faces[h / 3][next_halfedge(h) % 3]; }
inline Index apex(Faces faces, Index h) { return faces[h / 3][previous_halfedge(h) % 3]; }

// The halfedges of a mesh by the lower end of their edge. O(faces).
class EdgeBuckets {
 public:
  EdgeBuckets(Faces faces, Index point_count) : faces_(faces), end_(point_count + 1, 0) {
    bucketed_.resize(3 * faces.size());
    const auto for_lower_ends = [&](auto take) {
      Index h = 0;
      for (const auto& [a, b, c] : faces)
        for (const Index lower : {std::min(a, b), std::min(b, c), std::min(c, a)}) take(lower, h++);
    };
    for_lower_ends([&](Index lower, Index) { ++end_[lower + 1]; });
    std::partial_sum(end_.begin(), end_.end(), end_.begin());
    for_lower_ends([&](Index lower, Index h) { bucketed_[end_[lower]++] = h; });  // from start to end of its bucket
  }

  // Calls visit(span of halfedges) for each edge whose lower end is in first .. last - 1, by its lower and
  // then its upper end; the halfedges of an edge come in rising order. Buckets are small, so this is
  // nearly linear.
  template <class Visit>
  void visit(Index first, Index last, Visit visit_edge) const {
    std::vector<std::uint64_t> bucket;  // upper ends, and in the lower half the halfedges
    std::vector<Index> edge;
    for (Index p = first; p < last; ++p) {
      bucket.clear();
      for (Index i = p == 0 ? 0 : end_[p - 1]; i < end_[p]; ++i)
        bucket.push_back(static_cast<std::uint64_t>(upper(bucketed_[i])) << 32 |
                         static_cast<std::uint64_t>(bucketed_[i]));
      std::sort(bucket.begin(), bucket.end());
      for (std::size_t i = 0; i < bucket.size();) {
        edge.clear();
        const std::uint64_t upper_end = bucket[i] >> 32;
        for (; i < bucket.size() && bucket[i] >> 32 == upper_end; ++i)
          edge.push_back(static_cast<Index>(bucket[i] & 0xffffffff));
        visit_edge(Indices(edge));
      }
    }
  }

 private:
  Index upper(Index h) const { return std::max(origin(faces_, h), target(faces_, h)); }

  Faces faces_;
  Array<Index> end_, bucketed_;
};

}  // namespace bldsimp
