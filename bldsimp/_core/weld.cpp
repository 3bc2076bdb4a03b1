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

inline void prefetch([[maybe_unused]] const void* address) {
#if defined(__GNUC__)
  __builtin_prefetch(address, 1);
#endif
}

std::uint64_t hash(Vec3 p) {
  // Adding zero turns -0 into +0, so that equal numbers have equal bits.
  const auto bits = [](double v) { return std::bit_cast<std::uint64_t>(v + 0.0); };
  return mix(mix(mix(bits(p.x)) + bits(p.y)) + bits(p.z));
}

// Fills `position_of_row` with the number of each used row's position, in order of first use; returns one
// row for each position. Rows are hashed in blocks, so that the slots of a block are on their way from
// memory together.
std::vector<Index> distinct_positions(std::span<const Vec3> rows, std::span<const Face> faces,
                                      std::vector<Index>& position_of_row) {
  position_of_row.assign(rows.size(), -1);
  std::vector<std::uint8_t> used(rows.size(), 0);
  for (const Face& face : faces)
    for (const Index row : face) used[row] = 1;
  std::vector<Index> first_row;
  first_row.reserve(rows.size());
  std::vector<Index> slots(std::bit_ceil(std::max<std::size_t>(16, 2 * rows.size())), -1);
  const std::size_t mask = slots.size() - 1;
  constexpr std::size_t block = 32;
  std::array<std::size_t, block> home;
  for (std::size_t from = 0; from < rows.size(); from += block) {
    const std::size_t count = std::min(block, rows.size() - from);
    for (std::size_t i = 0; i < count; ++i) {
      home[i] = hash(rows[from + i]) & mask;
      prefetch(&slots[home[i]]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Index row = static_cast<Index>(from + i);
      if (!used[row]) continue;
      std::size_t slot = home[i];
      while (slots[slot] >= 0 && !(rows[first_row[slots[slot]]] == rows[row])) slot = (slot + 1) & mask;
      if (slots[slot] < 0) {
        slots[slot] = static_cast<Index>(first_row.size());
        first_row.push_back(row);
      }
      position_of_row[row] = slots[slot];
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

// A number that rises with x, for -inf to inf.
std::uint64_t rising_bits(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x + 0.0);
  return bits >> 63 ? ~bits : bits | std::uint64_t{1} << 63;
}

// Positions in lexicographic order: by 32 bits of x in two counting passes, then by all coordinates where
// those are equal. Four times as fast as comparing all the way.
std::vector<Index> sort_positions(std::span<const Vec3> rows, std::span<const Index> first_row) {
  struct Entry {
    std::uint32_t x;
    Index position;
  };
  if (first_row.empty()) return {};
  const auto bits_of = [&](std::size_t i) { return rising_bits(rows[first_row[i]].x); };
  std::uint64_t least = ~std::uint64_t{0}, greatest = 0;
  for (std::size_t i = 0; i < first_row.size(); ++i) {
    least = std::min(least, bits_of(i));
    greatest = std::max(greatest, bits_of(i));
  }
  const int shift = std::max(0, static_cast<int>(std::bit_width(greatest - least)) - 32);
  std::vector<Entry> entries(first_row.size()), sorted(first_row.size());
  for (std::size_t i = 0; i < entries.size(); ++i)
    entries[i] = {static_cast<std::uint32_t>((bits_of(i) - least) >> shift), static_cast<Index>(i)};
  for (const int digit : {0, 16}) {
    std::vector<Index> place((1 << 16) + 1, 0);
    for (const Entry& e : entries) ++place[(e.x >> digit & 0xffff) + 1];
    std::partial_sum(place.begin(), place.end(), place.begin());
    for (const Entry& e : entries) sorted[place[e.x >> digit & 0xffff]++] = e;
    entries.swap(sorted);
  }
  for (auto from = entries.begin(); from != entries.end();) {
    const auto to = std::find_if(from, entries.end(), [&](const Entry& e) { return e.x != from->x; });
    std::sort(from, to, [&](const Entry& a, const Entry& b) {
      return lexicographic_less(rows[first_row[a.position]], rows[first_row[b.position]]);
    });
    from = to;
  }
  std::vector<Index> order(entries.size());
  std::transform(entries.begin(), entries.end(), order.begin(), [](const Entry& e) { return e.position; });
  return order;
}

// Whether a face keeps three distinct points; if so, turns it and its rows until the least point leads.
bool turn_least_first(Face& face, Face& rows, std::span<const Index> point_of_row) {
  for (int i = 0; i < 3; ++i) face[i] = point_of_row[rows[i]];
  if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) return false;
  const int least = face[0] < face[1] ? (face[0] < face[2] ? 0 : 2) : (face[1] < face[2] ? 1 : 2);
  face = {face[least], face[(least + 1) % 3], face[(least + 2) % 3]};
  rows = {rows[least], rows[(least + 1) % 3], rows[(least + 2) % 3]};
  return true;
}

// Rows that copies of a face have for the same corner stand for one another: which of the copies stays must not
// decide which faces share a row. Leads each row of `first` and `second` to the least row of its class.
void unite(const Face& first, const Face& second, std::vector<Index>& class_of_row) {
  const auto find = [&](Index row) {
    while (class_of_row[row] != row) row = class_of_row[row] = class_of_row[class_of_row[row]];
    return row;
  };
  for (int i = 0; i < 3; ++i) {
    const auto [low, high] = std::minmax({find(first[i]), find(second[i])});
    class_of_row[high] = low;
  }
}

// Faces by their least point, then by the other two, then by the file: buckets are small, so that this is
// nearly linear. Copies end up side by side; only the first stays.
void sort_faces(std::span<const Face> input, Welded& welded) {
  struct Entry {
    std::uint64_t others;  // lower, then higher of the other two points, then the winding
    Index source;
    bool operator<(const Entry& e) const { return others != e.others ? others < e.others : source < e.source; }
  };
  const auto& points = welded.point_of_row;
  std::vector<Index> end(welded.points.size() + 1, 0);
  Face face;
  for (Face rows : input)
    if (turn_least_first(face, rows, points)) ++end[face[0] + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<Entry> entries(end.back());
  for (std::size_t f = 0; f < input.size(); ++f) {
    Face rows = input[f];
    if (!turn_least_first(face, rows, points)) continue;
    const auto [low, high] = std::minmax(face[1], face[2]);
    const auto key = static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high) << 1;
    entries[end[face[0]]++] = {key | (face[1] > face[2]), static_cast<Index>(f)};  // from start to end of its bucket
  }
  const auto start = [&](std::size_t p) { return p == 0 ? 0 : end[p - 1]; };
  parallel_for(welded.points.size(), [&](std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p) std::sort(entries.begin() + start(p), entries.begin() + end[p]);
  });

  std::vector<Index> class_of_row;
  welded.faces.reserve(entries.size());
  welded.rows.reserve(entries.size());
  welded.source.reserve(entries.size());
  for (const Entry& entry : entries) {
    Face rows = input[entry.source];
    turn_least_first(face, rows, points);
    if (!welded.faces.empty() && welded.faces.back() == face) {
      // Of copies the one with the least rows stays, whatever the order of the faces.
      if (class_of_row.empty()) {
        class_of_row.resize(points.size());
        std::iota(class_of_row.begin(), class_of_row.end(), 0);
      }
      unite(rows, welded.rows.back(), class_of_row);
      if (rows < welded.rows.back()) {
        welded.rows.back() = rows;
        welded.source.back() = entry.source;
      }
      continue;
    }
    welded.faces.push_back(face);
    welded.rows.push_back(rows);
    welded.source.push_back(entry.source);
  }
  // Roots come before what they lead to.
  for (Index& row : class_of_row) row = class_of_row[row];
  welded.class_of_row = std::move(class_of_row);
  welded.degenerate = static_cast<Index>(input.size() - entries.size());
  welded.duplicate = static_cast<Index>(entries.size() - welded.faces.size());
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

  sort_faces(faces, welded);
  return welded;
}

}  // namespace bldsimp
