#include "mesh/weld.hpp"

#include <bit>
#include <optional>
#include <unordered_map>

#include "mesh/corner_rows.hpp"
#include "mesh/index_sets.hpp"
#include "mesh/parallel.hpp"

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

// Fills `first_row` with the first used row at the position of each used row. Rows are hashed in blocks, so
// that the slots of a block are on their way from memory together. Each half of the table, which alone could
// hold all rows, is filled by itself.
void find_first_rows(Points rows, Faces faces, Array<Index>& first_row) {
  first_row.assign(rows.size(), -1);
  const Array<std::uint8_t> used = mark_used(faces, rows.size());
  const std::size_t half = std::bit_ceil(std::max<std::size_t>(16, rows.size())), mask = half - 1;
  Array<Index> slots(2 * half);
  constexpr std::size_t block = 32;
  const auto fill = [&](std::size_t first, std::size_t last) {
    std::fill(slots.begin() + first * half, slots.begin() + last * half, -1);
    std::array<std::size_t, block> home;
    for (std::size_t from = 0; from < rows.size(); from += block) {
      const std::size_t count = std::min(block, rows.size() - from);
      for (std::size_t i = 0; i < count; ++i) {
        home[i] = hash(rows[from + i]) & (2 * half - 1);
        prefetch(&slots[home[i]]);
      }
      for (std::size_t i = 0; i < count; ++i) {
        const Index row = static_cast<Index>(from + i);
        const std::size_t own = home[i] / half;
        if (!used[row] || own < first || own >= last) continue;
        std::size_t slot = home[i];
        while (slots[slot] >= 0 && !(rows[slots[slot]] == rows[row])) slot = own * half + ((slot + 1) & mask);
        if (slots[slot] < 0) slots[slot] = row;
        first_row[row] = slots[slot];
      }
    }
  };
  parallel_for(2, fill, rows.size() < least_parallel_work ? 2 : 1);
}

// Lets each point take the later points within `distance`; returns the point that each one becomes.
std::vector<Index> merge_near(Points points, double distance) {
  using Cell = std::array<std::int64_t, 3>;
  const auto hash_cell = [](const Cell& c) {
    return static_cast<std::size_t>(mix(mix(mix(static_cast<std::uint64_t>(c[0])) + static_cast<std::uint64_t>(c[1])) +
                                        static_cast<std::uint64_t>(c[2])));
  };
  const auto cell_of = [&](Vec3 p) {
    return Cell{static_cast<std::int64_t>(std::floor((p.x - points[0].x) / distance)),
                static_cast<std::int64_t>(std::floor((p.y - points[0].y) / distance)),
                static_cast<std::int64_t>(std::floor((p.z - points[0].z) / distance))};
  };
  std::unordered_map<Cell, std::vector<Index>, decltype(hash_cell)> kept(points.size(), hash_cell);
  std::vector<Index> target(points.size());
  const auto reach = [&](auto axis) {
    const auto [low, high] =
        std::minmax_element(points.begin(), points.end(), [&](Vec3 p, Vec3 q) { return axis(p) < axis(q); });
    return axis(*high) - axis(*low);
  };
  const double extent = std::max(
      {reach([](Vec3 p) { return p.x; }), reach([](Vec3 p) { return p.y; }), reach([](Vec3 p) { return p.z; })});
  if (!(extent / distance < 0x1p60)) {
    // Cells could not be numbered; two points that differ are farther apart than that.
    std::iota(target.begin(), target.end(), 0);
    return target;
  }
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

// The first rows of all positions, in lexicographic order of these: by 32 bits of x in two counting passes,
// then by all coordinates where those are equal. Four times as fast as comparing all the way.
Array<Index> sort_positions(Points rows, Indices first_row) {
  struct KeyedRow {
    std::uint32_t x;
    Index row;
  };
  std::uint64_t least = ~std::uint64_t{0}, greatest = 0;
  std::size_t count = 0;
  const auto for_positions = [&](auto take) {
    for (Index row = 0; row < std::ssize(rows); ++row)
      if (first_row[row] == row) take(row, rising_bits(rows[row].x));
  };
  for_positions([&](Index, std::uint64_t x) {
    least = std::min(least, x);
    greatest = std::max(greatest, x);
    ++count;
  });
  if (count == 0) return {};
  const int shift = std::max(0, static_cast<int>(std::bit_width(greatest - least)) - 32);
  Array<KeyedRow> entries(count), sorted(count);
  auto next = entries.begin();
  for_positions([&](Index row, std::uint64_t x) { *next++ = {static_cast<std::uint32_t>((x - least) >> shift), row}; });
  for (const int digit : {0, 16}) {
    std::vector<Index> place((1 << 16) + 1, 0);
    for (const KeyedRow& e : entries) ++place[(e.x >> digit & 0xffff) + 1];
    std::partial_sum(place.begin(), place.end(), place.begin());
    for (const KeyedRow& e : entries) sorted[place[e.x >> digit & 0xffff]++] = e;
    entries.swap(sorted);
  }
  for_runs(
      entries, [](const KeyedRow& a, const KeyedRow& b) { return a.x == b.x; },
      [&](std::span<KeyedRow> same) {
        std::sort(same.begin(), same.end(),
                  [&](const KeyedRow& a, const KeyedRow& b) { return lexicographic_less(rows[a.row], rows[b.row]); });
      });
  Array<Index> order(count);
  std::transform(entries.begin(), entries.end(), order.begin(), [](const KeyedRow& e) { return e.row; });
  return order;
}

// A face in the order in which faces go: by its least point, the lower and the higher of the other two, its
// winding, its place in the file.
struct SortedFace {
  std::uint64_t least_and_low;
  std::uint64_t rest;  // 31 bits for the third point, one for the winding, 32 for the input face
  auto operator<=>(const SortedFace&) const = default;

  static std::uint64_t wide(Index i) { return static_cast<std::uint64_t>(i); }
  SortedFace() = default;
  SortedFace(Index least, Index second, Index third, std::size_t source) {
    const auto [low, high] = std::minmax(second, third);
    least_and_low = wide(least) << 32 | wide(low);
    rest = (wide(high) << 1 | (second > third)) << 32 | source;
  }
  bool is_copy_of(const SortedFace& other) const {
    return least_and_low == other.least_and_low && rest >> 32 == other.rest >> 32;
  }
  Index source() const { return static_cast<Index>(rest & 0xffffffff); }
  Face face() const {
    const Index least = static_cast<Index>(least_and_low >> 32), low = static_cast<Index>(least_and_low & 0xffffffff);
    const Index high = static_cast<Index>(rest >> 33);
    return rest >> 32 & 1 ? Face{least, high, low} : Face{least, low, high};
  }
};

// Calls take(least point, sorted face) for each face in first .. last - 1 that keeps three distinct points.
template <class Take>
void for_sorted_faces(Faces input, Indices point_of_row, std::size_t first, std::size_t last, Take take) {
  for (std::size_t f = first; f < last; ++f) {
    const Index a = point_of_row[input[f][0]], b = point_of_row[input[f][1]], c = point_of_row[input[f][2]];
    if (a == b || b == c || c == a) continue;
    const Index least = std::min({a, b, c}), second = least == a ? b : least == b ? c : a;
    take(least, SortedFace(least, second, a ^ b ^ c ^ least ^ second, f));
  }
}

// Faces by points near their least one: blocks of the file are dealt out to buckets, then each bucket is
// sorted, on all cores, and since every face has a place of its own in the order, to the same end.
Array<SortedFace> sort_faces(Faces input, Indices point_of_row, std::size_t point_count) {
  constexpr std::size_t block = 1 << 17;
  constexpr int most_buckets = 14;  // as a power of 2: their ends stay in the cache
  const std::size_t blocks = (input.size() + block - 1) / block;
  const int shift = std::max(0, static_cast<int>(std::bit_width(point_count)) - most_buckets);
  const std::size_t buckets = (point_count >> shift) + 1;
  std::vector<Index> cursor(blocks * buckets, 0);
  const auto visit = [&](auto take) {
    const auto deal_out = [&](std::size_t first, std::size_t last) {
      for (std::size_t b = first; b < last; ++b)
        for_sorted_faces(
            input, point_of_row, b * block, std::min(input.size(), (b + 1) * block),
            [&](Index least, const SortedFace& face) { take(cursor[b * buckets + (least >> shift)], face); });
    };
    parallel_for(blocks, deal_out, 1);
  };
  visit([](Index& count, const SortedFace&) { ++count; });
  std::vector<Index> start(buckets + 1, 0);
  Index total = 0;
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    start[bucket] = total;
    for (std::size_t b = 0; b < blocks; ++b) total += std::exchange(cursor[b * buckets + bucket], total);
  }
  start[buckets] = total;
  Array<SortedFace> sorted(total);
  visit([&](Index& place, const SortedFace& face) { sorted[place++] = face; });
  const auto sort_buckets = [&](std::size_t first, std::size_t last) {
    for (std::size_t b = first; b < last; ++b) std::sort(sorted.begin() + start[b], sorted.begin() + start[b + 1]);
  };
  parallel_for(buckets, sort_buckets, 1 << 10);
  return sorted;
}

// The input rows of a face's corners.
Face rows_at(const Face& face, const Face& input, Indices point_of_row) {
  Face rows;
  for (int i = 0; i < 3; ++i) rows[i] = row_at(face[i], input, point_of_row);
  return rows;
}

// Copies stand side by side; of those of a layer the one with the least rows stays, whatever the order of the file.
void lay_faces(Faces input, Indices layer, WeldResult& welded) {
  // Rows that copies of a face have for the same corner stand for one another: which of the copies stays must not
  // decide which faces share a row.
  std::optional<IndexSets> classes;
  const Array<SortedFace> sorted = sort_faces(input, welded.point_of_row, welded.points.size());
  const auto layer_of = [&](Index source) { return layer.empty() ? 0 : layer[source]; };
  welded.faces.reserve(sorted.size());
  welded.source.reserve(sorted.size());
  for (std::size_t i = 0, run = 0; i < sorted.size(); ++i) {
    const Face face = sorted[i].face();
    const Index source = sorted[i].source();
    if (i == 0 || !sorted[i].is_copy_of(sorted[i - 1])) run = welded.faces.size();
    const auto copy = std::find_if(welded.source.begin() + run, welded.source.end(),
                                   [&](Index other) { return layer_of(other) == layer_of(source); });
    if (copy == welded.source.end()) {
      welded.faces.push_back(face);
      welded.source.push_back(source);
      continue;
    }
    if (!classes) classes.emplace(welded.point_of_row.size());
    const Face rows = rows_at(face, input[source], welded.point_of_row);
    const Face least = rows_at(face, input[*copy], welded.point_of_row);
    for (int k = 0; k < 3; ++k) classes->join(rows[k], least[k]);
    if (rows < least) *copy = source;
  }
  if (classes) welded.class_of_row = std::move(*classes).roots();
  welded.degenerate = static_cast<Index>(input.size() - sorted.size());
  welded.duplicate = static_cast<Index>(sorted.size() - welded.faces.size());
}

}  // namespace

Array<std::uint8_t> mark_used(Faces faces, std::size_t count) {
  Array<std::uint8_t> used(count, 0);
  for (const Face& face : faces)
    for (const Index row : face) used[row] = 1;
  return used;
}

WeldResult weld(Points rows, Faces faces, double distance, Indices layer) {
  WeldResult welded;
  Array<Index>& point_of_row = welded.point_of_row;
  find_first_rows(rows, faces, point_of_row);
  const Array<Index> order = sort_positions(rows, point_of_row);
  welded.points.resize(order.size());
  Array<Index> point_at(rows.size());  // by the first row of a position
  for (std::size_t i = 0; i < order.size(); ++i) {
    point_at[order[i]] = static_cast<Index>(i);
    welded.points[i] = rows[order[i]];
  }
  if (distance > 0 && !welded.points.empty()) {
    const std::vector<Index> target = merge_near(welded.points, distance);
    for (std::size_t i = 0; i < target.size(); ++i) {
      welded.moved = std::max(welded.moved, length(welded.points[i] - welded.points[target[i]]));
      point_at[order[i]] = target[i];
    }
  }
  for (Index& row : point_of_row)
    if (row >= 0) row = point_at[row];

  lay_faces(faces, layer, welded);
  return welded;
}

}  // namespace bldsimp
