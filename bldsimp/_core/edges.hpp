// The edges of a mesh, each with the halfedges on it.
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

// The halfedges of a mesh by the lower end of their edge. O(faces).
class EdgeBuckets {
 public:
  EdgeBuckets(std::span<const Face> faces, Index point_count) : faces_(faces), end_(point_count + 1, 0) {
    const Index count = static_cast<Index>(3 * faces.size());
    bucketed_.resize(count);
    for (Index h = 0; h < count; ++h) ++end_[lower(h) + 1];
    std::partial_sum(end_.begin(), end_.end(), end_.begin());
    for (Index h = 0; h < count; ++h) bucketed_[end_[lower(h)]++] = h;  // from start to end of its bucket
  }

  // Calls visit(span of halfedges) for each edge whose lower end is in first .. last - 1, by its lower and
  // then its upper end; the halfedges of an edge come in rising order. Buckets are small, so this is
  // nearly linear.
  template <class Visit>
  void visit(Index first, Index last, Visit visit_edge) const {
    std::vector<std::pair<Index, Index>> bucket;
    std::vector<Index> edge;
    for (Index p = first; p < last; ++p) {
      bucket.clear();
      for (Index i = p == 0 ? 0 : end_[p - 1]; i < end_[p]; ++i) bucket.push_back({upper(bucketed_[i]), bucketed_[i]});
      std::sort(bucket.begin(), bucket.end());
      for (std::size_t i = 0; i < bucket.size();) {
        edge.clear();
        const Index upper_end = bucket[i].first;
        for (; i < bucket.size() && bucket[i].first == upper_end; ++i) edge.push_back(bucket[i].second);
        visit_edge(std::span<const Index>(edge));
      }
    }
  }

 private:
  Index lower(Index h) const { return std::min(origin(faces_, h), target(faces_, h)); }
  Index upper(Index h) const { return std::max(origin(faces_, h), target(faces_, h)); }

  std::span<const Face> faces_;
  std::vector<Index> end_, bucketed_;
};

// Sets of faces, joined; the root is the least face, so that the result knows no order.
class FaceSets {
 public:
  explicit FaceSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  Index find(Index f) {
    while (parent_[f] != f) f = parent_[f] = parent_[parent_[f]];
    return f;
  }
  void join(Index f, Index g) {
    f = find(f);
    g = find(g);
    parent_[std::max(f, g)] = std::min(f, g);
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace bldsimp
