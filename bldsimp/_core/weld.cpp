#include "weld.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <unordered_map>

#include "parallel.hpp"

namespace bldsimp {
namespace {

std::uint64_t mix(std::uint64_t h) {
  h ^= h >> 32;
  h *= 0xd6e8feb86659fd93ull;
  h ^= h >> 32;
  return h;
}

std::uint64_t hash(Vec3 p) {
  // Adding zero turns -0 into +0, so that equal numbers have equal bits.
  const auto bits = [](double v) { return std::bit_cast<std::uint64_t>(v + 0.0); };
  return mix(mix(mix(bits(p.x)) + bits(p.y)) + bits(p.z));
}

// Fills `class_of_row` with the number of each used row's position, in order of first use; returns
// one row for each position.
std::vector<Index> distinct_positions(std::span<const Vec3> rows, std::span<const Face> faces,
                                      std::vector<Index>& class_of_row) {
  std::vector<Index> first_row;
  class_of_row.assign(rows.size(), -1);
  std::vector<Index> slots(std::bit_ceil(std::max<std::size_t>(16, 2 * rows.size())), -1);
  const std::size_t mask = slots.size() - 1;
  for (const Face& face : faces) {
    for (const Index row : face) {
      if (class_of_row[row] >= 0) continue;
      std::size_t slot = hash(rows[row]) & mask;
      while (slots[slot] >= 0 && !(rows[first_row[slots[slot]]] == rows[row])) slot = (slot + 1) & mask;
      if (slots[slot] < 0) {
        slots[slot] = static_cast<Index>(first_row.size());
        first_row.push_back(row);
      }
      class_of_row[row] = slots[slot];
    }
  }
  return first_row;
}

// Lets each point take the later points within `distance`; returns the point that each one becomes.
std::vector<Index> merge_near(std::span<const Vec3> points, double distance) {
  using Cell = std::array<std::int64_t, 3>;
  const auto hash_cell = [](const Cell& c) {
    return static_cast<std::size_t>(
        mix(mix(mix(static_cast<std::uint64_t>(c[0])) + static_cast<std::uint64_t>(c[1])) +
            static_cast<std::uint64_t>(c[2])));
  };
  const auto cell_of = [&](Vec3 p) {
    return Cell{static_cast<std::int64_t>(std::floor((p.x - points[0].x) / distance)),
                static_cast<std::int64_t>(std::floor((p.y - points[0].y) / distance)),
                static_cast<std::int64_t>(std::floor((p.z - points[0].z) / distance))};
  };
  std::unordered_map<Cell, std::vector<Index>, decltype(hash_cell)> kept(points.size(), hash_cell);
  std::vector<Index> target(points.size());
  for (Index i = 0; i < static_cast<Index>(points.size()); ++i) {
    const Cell cell = cell_of(points[i]);
    target[i] = i;
    for (int n = 0; n < 27 && target[i] == i; ++n) {
      const auto found = kept.find({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1});
      if (found == kept.end()) continue;
      for (const Index j : found->second) {
        if (length(points[i] - points[j]) <= distance) {
          target[i] = j;
          break;
        }
      }
    }
    if (target[i] == i) kept[cell].push_back(i);
  }
  return target;
}

// Positions in lexicographic order. Most are told apart by x alone, which is kept beside the number.
std::vector<Index> sort_positions(std::span<const Vec3> rows, std::span<const Index> first_row) {
  struct Entry {
    double x;
    Index position;
  };
  std::vector<Entry> entries(first_row.size());
  for (std::size_t i = 0; i < entries.size(); ++i) entries[i] = {rows[first_row[i]].x, static_cast<Index>(i)};
  const auto less = [&](const Entry& a, const Entry& b) {
    return a.x != b.x ? a.x < b.x : lexicographic_less(rows[first_row[a.position]], rows[first_row[b.position]]);
  };
  const auto middle = entries.begin() + static_cast<std::ptrdiff_t>(entries.size() / 2);
  parallel_for(2, [&](std::size_t begin, std::size_t end) {
    if (begin == 0) std::sort(entries.begin(), middle, less);
    if (end == 2) std::sort(middle, entries.end(), less);
  }, entries.size() < least_parallel_work ? 2 : 1);
  std::inplace_merge(entries.begin(), middle, entries.end(), less);
  std::vector<Index> order(entries.size());
  std::transform(entries.begin(), entries.end(), order.begin(), [](const Entry& e) { return e.position; });
  return order;
}

// Faces by their least point, then by the other two: buckets are small, so this is nearly linear.
void sort_faces(Welded& welded) {
  const auto less = [&](Index f, Index g) {
    const Face &a = welded.faces[f], &b = welded.faces[g];
    const auto [a_low, a_high] = std::minmax(a[1], a[2]);
    const auto [b_low, b_high] = std::minmax(b[1], b[2]);
    if (a_low != b_low) return a_low < b_low;
    if (a_high != b_high) return a_high < b_high;
    return a[1] != b[1] ? a[1] < b[1] : welded.source[f] < welded.source[g];
  };
  const Index count = static_cast<Index>(welded.faces.size());
  std::vector<Index> end(welded.points.size() + 1, 0), order(count);
  for (const Face& face : welded.faces) ++end[face[0] + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  for (Index f = 0; f < count; ++f) order[end[welded.faces[f][0]]++] = f;  // from start to end of its bucket
  parallel_for(welded.points.size(), [&](std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p)
      std::sort(order.begin() + (p == 0 ? 0 : end[p - 1]), order.begin() + end[p], less);
  });

  std::vector<Face> faces, rows;
  std::vector<Index> source;
  faces.reserve(count);
  rows.reserve(count);
  source.reserve(count);
  for (const Index f : order) {
    if (!faces.empty() && faces.back() == welded.faces[f]) {
      ++welded.duplicate;
      continue;
    }
    faces.push_back(welded.faces[f]);
    rows.push_back(welded.rows[f]);
    source.push_back(welded.source[f]);
  }
  welded.faces = std::move(faces);
  welded.rows = std::move(rows);
  welded.source = std::move(source);
}

}  // namespace

Welded weld(std::span<const Vec3> rows, std::span<const Face> faces, double distance) {
  Welded welded;
  const std::vector<Index> first_row = distinct_positions(rows, faces, welded.point_of_row);

  const std::vector<Index> order = sort_positions(rows, first_row);
  std::vector<Index> point_of_class(order.size());
  welded.points.reserve(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    point_of_class[order[i]] = static_cast<Index>(i);
    welded.points.push_back(rows[first_row[order[i]]]);
  }
  if (distance > 0 && !welded.points.empty()) {
    const std::vector<Index> target = merge_near(welded.points, distance);
    for (std::size_t i = 0; i < target.size(); ++i)
      welded.moved = std::max(welded.moved, length(welded.points[i] - welded.points[target[i]]));
    for (Index& p : point_of_class) p = target[p];
  }
  for (Index& p : welded.point_of_row)
    if (p >= 0) p = point_of_class[p];

  welded.faces.reserve(faces.size());
  welded.rows.reserve(faces.size());
  welded.source.reserve(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    Face face;
    for (int i = 0; i < 3; ++i) face[i] = welded.point_of_row[faces[f][i]];
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) {
      ++welded.degenerate;
      continue;
    }
    const auto least = std::min_element(face.begin(), face.end()) - face.begin();
    Face row = faces[f];
    std::rotate(row.begin(), row.begin() + least, row.end());
    std::rotate(face.begin(), face.begin() + least, face.end());
    welded.faces.push_back(face);
    welded.rows.push_back(row);
    welded.source.push_back(static_cast<Index>(f));
  }
  sort_faces(welded);
  return welded;
}

}  // namespace bldsimp
