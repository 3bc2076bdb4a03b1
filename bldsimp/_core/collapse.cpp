#include "collapse.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <tuple>

#include "box_tree.hpp"
#include "collapser.hpp"
#include "crossings.hpp"
#include "parallel.hpp"

namespace bldsimp {
namespace {

// Faces beyond this are first collapsed in blocks of about as many, side by side.
constexpr std::size_t kBlock = 16384;

// What is left of the surface, and how far that is.
struct Now {
  std::vector<Vec3> points;
  std::vector<Face> faces;
  std::vector<Index> source;
};

// A block: some faces of what is left, over points of their own.
struct Block {
  std::vector<Index> members;  // faces
  std::vector<Index> points;   // of what is left
  std::optional<Collapsed> result;
};

template <class T>
std::vector<T> taken(std::span<const T> all, std::span<const Index> chosen) {
  std::vector<T> some;
  some.reserve(chosen.size());
  for (const Index i : chosen) some.push_back(all[i]);
  return some;
}

Now whole(const CollapseInput& input) {
  Now now{{input.points.begin(), input.points.end()}, {}, {}};
  for (std::size_t f = 0; f < input.surface.size(); ++f) {
    if (input.left_out[f]) continue;
    now.faces.push_back(input.surface[f]);
    now.source.push_back(static_cast<Index>(f));
  }
  return now;
}

void divide(std::vector<Index> members, std::span<const Face> faces, std::span<const Vec3> middles,
            std::vector<Block>& blocks) {
  if (members.size() <= kBlock) {
    std::sort(members.begin(), members.end());
    blocks.push_back({std::move(members), {}, {}});
    return;
  }
  Box box;
  for (const Index f : members) box.add(middles[f]);
  const Vec3 size = box.high - box.low;
  double Vec3::*axis = &Vec3::x;
  if (size.y > size.*axis) axis = &Vec3::y;
  if (size.z > size.*axis) axis = &Vec3::z;
  const auto half = members.begin() + static_cast<std::ptrdiff_t>(members.size() / 2);
  std::nth_element(members.begin(), half, members.end(), [&](Index f, Index g) {
    return std::tuple(middles[f].*axis, f) < std::tuple(middles[g].*axis, g);
  });
  divide({members.begin(), half}, faces, middles, blocks);
  divide({half, members.end()}, faces, middles, blocks);
}

std::vector<Block> blocks_of(const Now& now) {
  std::vector<Vec3> middles;
  for (const auto& [a, b, c] : now.faces) middles.push_back(now.points[a] + now.points[b] + now.points[c]);
  std::vector<Index> all(now.faces.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<Block> blocks;
  divide(std::move(all), now.faces, middles, blocks);
  return blocks;
}

// Points that more than one block uses, or that hold what is left out.
std::vector<std::uint8_t> shared_points(const CollapseInput& input, const Now& now, std::span<const Block> blocks) {
  std::vector<std::uint8_t> shared(now.points.size(), 0);
  std::vector<Index> user(now.points.size(), -1);
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (const Index f : blocks[b].members)
      for (const Index p : now.faces[f]) {
        if (user[p] >= 0 && user[p] != static_cast<Index>(b)) shared[p] = 1;
        user[p] = static_cast<Index>(b);
      }
  std::vector<Index> out;
  for (std::size_t f = 0; f < input.surface.size(); ++f)
    if (input.left_out[f]) out.push_back(static_cast<Index>(f));
  if (out.empty()) return shared;
  const FaceTree gone(input.points, taken(input.surface, out));
  for (const Face& face : now.faces) {
    const auto& [a, b, c] = face;
    const std::array<Vec3, 3> own{now.points[a], now.points[b], now.points[c]};
    Index nearest = 0;
    if (gone.within((1.0 / 3) * (own[0] + own[1] + own[2]), input.tolerance + longest_side(own), nearest))
      for (const Index p : face) shared[p] = 1;
  }
  return shared;
}

void collapse_block(const CollapseInput& input, const Now& now, std::span<const std::uint8_t> shared, Block& block) {
  for (const Index f : block.members) block.points.insert(block.points.end(), now.faces[f].begin(), now.faces[f].end());
  std::sort(block.points.begin(), block.points.end());
  block.points.erase(std::unique(block.points.begin(), block.points.end()), block.points.end());
  auto faces = taken<Face>(now.faces, block.members);
  for (Face& face : faces)
    for (Index& p : face)
      p = static_cast<Index>(std::lower_bound(block.points.begin(), block.points.end(), p) - block.points.begin());
  const auto points = taken<Vec3>(now.points, block.points);
  const auto sources = taken<Index>(now.source, block.members);
  const auto label = taken(input.label, sources);
  const auto pinned = taken(input.pinned, sources);
  const auto stays = taken(shared, block.points);
  const std::vector<std::uint8_t> none(faces.size(), 0);
  block.result = Collapser({points, faces, label, none, points, faces, label, pinned, stays, input.tolerance,
                            input.decimals, input.single})
                     .run();
}

// What is left after all blocks; those without a result stay as they were.
Now joined(const Now& before, std::span<const Block> blocks, std::span<const std::uint8_t> shared,
           std::vector<Index>& block_of_face) {
  Now after{before.points, {}, {}};
  block_of_face.clear();
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const Block& block = blocks[b];
    if (!block.result) {
      for (const Index f : block.members) {
        after.faces.push_back(before.faces[f]);
        after.source.push_back(before.source[f]);
      }
    } else {
      const Collapsed& own = *block.result;
      for (std::size_t t = 0; t < own.triangles.size(); ++t) {
        const auto& [p, q, r] = own.triangles[t];
        after.faces.push_back({block.points[p], block.points[q], block.points[r]});
        after.source.push_back(before.source[block.members[own.source[t]]]);
      }
      for (std::size_t p = 0; p < block.points.size(); ++p)
        if (!shared[block.points[p]]) after.points[block.points[p]] = own.points[p];
    }
    block_of_face.resize(after.faces.size(), static_cast<Index>(b));
  }
  return after;
}

// What was done in all.
void add(const Collapsed& own, Collapsed& total) {
  total.accepted += own.accepted;
  total.moved += own.moved;
  for (std::size_t i = 0; i < total.refusals.size(); ++i) total.refusals[i] += own.refusals[i];
}

// Where faces of two blocks pass through one another.
struct Meeting {
  Index first, second;  // blocks
  Box place;
};

std::vector<Meeting> meetings(const Now& now, std::span<const Index> block_of_face) {
  std::vector<Meeting> found;
  const std::vector<std::uint8_t> all(now.faces.size(), 1);
  const auto box = [&](Index f) {
    Box own;
    for (const Index p : now.faces[f]) own.add(now.points[p]);
    return own;
  };
  for (const auto& [f, g] : find_crossings(now.points, now.faces, all)) {
    if (block_of_face[f] == block_of_face[g]) continue;
    const auto& [first, second] = std::minmax(block_of_face[f], block_of_face[g]);
    found.push_back({first, second, box(f).common(box(g))});
  }
  return found;
}

// Blocks know nothing of one another: those that pass through another one, where they did not before, stay as they
// were.
Now parted(const CollapseInput& input, const Now& before, std::vector<Block>& blocks,
           std::span<const std::uint8_t> shared, Collapsed& total) {
  std::vector<Index> block_of_face;
  Now after = joined(before, blocks, shared, block_of_face);
  const auto now = meetings(after, block_of_face);
  if (!now.empty()) {
    std::vector<Index> block_before(before.faces.size());
    for (std::size_t b = 0; b < blocks.size(); ++b)
      for (const Index f : blocks[b].members) block_before[f] = static_cast<Index>(b);
    auto old = meetings(before, block_before);
    const Vec3 around{2 * input.tolerance, 2 * input.tolerance, 2 * input.tolerance};
    for (Meeting& one : old) one.place = {one.place.low - around, one.place.high + around};
    for (const Meeting& one : now) {
      const bool known = std::any_of(old.begin(), old.end(), [&](const Meeting& o) {
        return o.first == one.first && o.second == one.second && o.place.meets(one.place);
      });
      if (known) continue;
      for (const Index b : {one.first, one.second}) blocks[b].result.reset();
    }
    after = joined(before, blocks, shared, block_of_face);
  }
  for (const Block& block : blocks)
    if (block.result) add(*block.result, total);
  return after;
}

void collapse_blocks(const CollapseInput& input, Now& now, Collapsed& total) {
  std::vector<Block> blocks = blocks_of(now);
  if (blocks.size() < 2) return;
  const auto shared = shared_points(input, now, blocks);
  parallel_for(
      blocks.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) collapse_block(input, now, shared, blocks[b]);
      },
      1);
  now = parted(input, now, blocks, shared, total);
}

}  // namespace

Collapsed collapse(const CollapseInput& input) {
  Now now = whole(input);
  const bool fewer = now.faces.size() < input.surface.size();
  Collapsed total;
  collapse_blocks(input, now, total);
  const auto label = taken<Index>(input.label, now.source);
  const auto pinned = taken<std::uint8_t>(input.pinned, now.source);
  const std::vector<std::uint8_t> none(now.points.size(), 0);
  const Left left{input.points, input.surface, input.label,     input.left_out, now.points,  now.faces, label,
                  pinned,       none,          input.tolerance, input.decimals, input.single};
  Collapser collapser(left);
  Collapsed result = collapser.run();
  for (Index& f : result.source) f = now.source[f];
  add(total, result);
  result.holder = collapser.holders();
  if (fewer || result.accepted + result.moved > 0) result.deviation = collapser.deviation(result);
  return result;
}

}  // namespace bldsimp
