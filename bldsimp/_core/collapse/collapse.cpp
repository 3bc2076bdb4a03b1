#include "collapse/collapse.hpp"

#include "collapse/collapser.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/crossings.hpp"
#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

// Faces beyond this are first collapsed in blocks of about as many, side by side.
constexpr std::size_t kBlock = 4096;

// What is left of the surface, and how far that is.
struct Remainder {
  std::vector<Vec3> points;
  std::vector<Face> faces;
  std::vector<Index> source;
};

// A block: some faces of what is left, over points of their own.
struct SurfaceBlock {
  std::vector<Index> members;  // faces
  Box box;                     // that they and what becomes of them are in
  std::vector<Index> points;   // of what is left
  CollapseResult result;
  bool stays = false;  // as it was
};

// What blocks have left, put together.
struct JoinedBlocks {
  Remainder now;
  std::vector<Index> block;
  std::vector<std::uint8_t> changed;
};

template <class T>
std::vector<T> select(std::span<const T> all, Indices chosen) {
  std::vector<T> some;
  some.reserve(chosen.size());
  for (const Index i : chosen) some.push_back(all[i]);
  return some;
}

Remainder start(const CollapseInput& input) {
  const Points positions = input.positions.empty() ? input.points : input.positions;
  Remainder now{{positions.begin(), positions.end()}, {}, {}};
  for (std::size_t f = 0; f < input.surface.size(); ++f) {
    if (input.left_out[f]) continue;
    now.faces.push_back(input.surface[f]);
    now.source.push_back(static_cast<Index>(f));
  }
  return now;
}

void divide(std::vector<Index> members, Faces faces, Points middles, std::vector<SurfaceBlock>& blocks) {
  if (members.size() <= kBlock) {
    std::sort(members.begin(), members.end());
    blocks.push_back({std::move(members), {}, {}, {}, false});
    return;
  }
  Box box;
  for (const Index f : members) box.add(middles[f]);
  double Vec3::* const axis = longest_axis(box);
  const auto half = members.begin() + static_cast<std::ptrdiff_t>(members.size() / 2);
  std::nth_element(members.begin(), half, members.end(),
                   [&](Index f, Index g) { return std::tuple(middles[f].*axis, f) < std::tuple(middles[g].*axis, g); });
  divide({members.begin(), half}, faces, middles, blocks);
  divide({half, members.end()}, faces, middles, blocks);
}

std::vector<SurfaceBlock> divide_into_blocks(const Remainder& now) {
  std::vector<Vec3> middles;
  for (const auto& [a, b, c] : now.faces) middles.push_back(now.points[a] + now.points[b] + now.points[c]);
  std::vector<SurfaceBlock> blocks;
  divide(list_indices(now.faces.size()), now.faces, middles, blocks);
  return blocks;
}

// Points that more than one block uses, or that hold what is left out.
std::vector<std::uint8_t> find_shared_points(const CollapseInput& input, const Remainder& now,
                                             std::span<const SurfaceBlock> blocks) {
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
  const FaceTree gone(input.points, select(input.surface, out));
  for (const Face& face : now.faces) {
    const Triangle own = corners_of(face, now.points);
    Index nearest = 0;
    if (gone.within(centroid(own), input.tolerance + longest_side(own), nearest))
      for (const Index p : face) shared[p] = 1;
  }
  return shared;
}

void add_boxes(const Remainder& now, double tolerance, std::span<SurfaceBlock> blocks) {
  const Vec3 around{tolerance, tolerance, tolerance};
  for (SurfaceBlock& block : blocks) {
    for (const Index f : block.members)
      for (const Index p : now.faces[f]) block.box.add(now.points[p]);
    block.box.add({block.box.low - around, block.box.high + around});
  }
}

// Faces of other blocks that this one may come to cross.
std::vector<Face> find_faces_beside(const Remainder& now, std::span<const SurfaceBlock> blocks,
                                    const SurfaceBlock& own) {
  std::vector<Face> beside;
  for (const SurfaceBlock& block : blocks) {
    if (&block == &own || !block.box.meets(own.box)) continue;
    for (const Index f : block.members) {
      if (box_of(corners_of(now.faces[f], now.points)).meets(own.box)) beside.push_back(now.faces[f]);
    }
  }
  return beside;
}

void collapse_block(const CollapseInput& input, const Remainder& now, const HeldFacets& held, const Walls& walls,
                    Flags shared, std::span<const SurfaceBlock> blocks, SurfaceBlock& block) {
  auto faces = select<Face>(now.faces, block.members), beside = find_faces_beside(now, blocks, block);
  for (const auto* list : {&faces, &beside})
    for (const Face& face : *list) append(block.points, face);
  sort_unique(block.points);
  for (auto* list : {&faces, &beside})
    for (Face& face : *list)
      for (Index& p : face)
        p = static_cast<Index>(std::lower_bound(block.points.begin(), block.points.end(), p) - block.points.begin());
  const auto points = select<Vec3>(now.points, block.points);
  const auto sources = select<Index>(now.source, block.members);
  std::vector<Face> surface;
  for (std::size_t i = 0; i < faces.size(); ++i)
    if (!input.is_filling(sources[i])) surface.push_back(faces[i]);
  block.stays = surface.empty();
  if (block.stays) return;
  const auto label = select(input.label, sources);
  const auto pinned = select(input.pinned, sources);
  const auto stays = select(shared, block.points);
  const auto fixed = input.fixed.empty() ? std::vector<std::uint8_t>{} : select(input.fixed, block.points);
  const auto planes = select<Index>(held.plane_of_face, sources);
  const auto noticed = select<double>(held.noticed, sources);
  block.result = Collapser({points, surface, faces, label, points, faces, label, pinned, stays, beside, input.tolerance,
                            input.decimals, input.single, input.progress, fixed, planes, held.planes, noticed, walls})
                     .run();
}

JoinedBlocks join_blocks(const Remainder& now, std::span<const SurfaceBlock> blocks) {
  JoinedBlocks after{{now.points, {}, {}}, {}, {}};
  const auto add = [&](std::size_t b, Index from, const Face& face) {
    const Face& old = now.faces[from];
    const bool same = face == old && std::all_of(face.begin(), face.end(),
                                                 [&](Index p) { return after.now.points[p] == now.points[p]; });
    after.now.faces.push_back(face);
    after.now.source.push_back(now.source[from]);
    after.block.push_back(static_cast<Index>(b));
    after.changed.push_back(!same);
  };
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const auto& [members, box, points, result, stays] = blocks[b];
    if (stays) {
      for (const Index f : members) add(b, f, now.faces[f]);
      continue;
    }
    for (std::size_t t = 0; t < result.triangles.size(); ++t) {
      Face face = result.triangles[t];
      for (Index& p : face) {
        after.now.points[points[p]] = result.points[p];
        p = points[p];
      }
      add(b, members[result.source[t]], face);
    }
  }
  return after;
}

// Blocks know others as they were. Where two have changed so that they cross, or points of both came to one place, one
// is to stay; whether any is.
bool part_blocks(const Remainder& before, const JoinedBlocks& after, std::span<SurfaceBlock> blocks) {
  bool any = false;
  for (const auto& [f, g] : find_crossings(after.now.points, after.now.faces, after.changed)) {
    if (after.block[f] == after.block[g] || !after.changed[f] || !after.changed[g]) continue;
    blocks[std::max(after.block[f], after.block[g])].stays = any = true;
  }
  std::vector<std::pair<Vec3, Index>> places;  // of moved points, with their blocks
  for (std::size_t f = 0; f < after.now.faces.size(); ++f)
    for (const Index p : after.now.faces[f])
      if (!(after.now.points[p] == before.points[p])) places.push_back({after.now.points[p], after.block[f]});
  std::sort(places.begin(), places.end(), [](const auto& p, const auto& q) {
    return p.first == q.first ? p.second < q.second : lexicographic_less(p.first, q.first);
  });
  for (std::size_t i = 1; i < places.size(); ++i)
    if (places[i].first == places[i - 1].first && places[i].second != places[i - 1].second)
      blocks[places[i].second].stays = any = true;
  return any;
}

void collapse_blocks(const CollapseInput& input, const HeldFacets& held, const Walls& walls, Remainder& now,
                     CollapseResult& total) {
  std::vector<SurfaceBlock> blocks = divide_into_blocks(now);
  if (blocks.size() < 2) return;
  const auto shared = find_shared_points(input, now, blocks);
  add_boxes(now, input.tolerance, blocks);
  parallel_each(blocks.size(), [&](Index b) { collapse_block(input, now, held, walls, shared, blocks, blocks[b]); }, 1);
  JoinedBlocks after = join_blocks(now, blocks);
  if (part_blocks(now, after, blocks)) after = join_blocks(now, blocks);
  for (const SurfaceBlock& block : blocks) {
    if (block.stays) continue;
    total.accepted += block.result.accepted;
    total.moved += block.result.moved;
    for (std::size_t i = 0; i < total.refusals.size(); ++i) total.refusals[i] += block.result.refusals[i];
  }
  now = std::move(after.now);
}

// The planes that are kept, for faces of the input.
HeldFacets hold_facets(const CollapseInput& input, const Remainder& now) {
  HeldFacets held = find_held_facets(now.points, now.faces, select<Index>(input.label, now.source), input.tolerance);
  std::vector<Index> plane_of_face(input.surface.size(), -1);
  std::vector<double> noticed(input.surface.size());
  for (std::size_t f = 0; f < now.faces.size(); ++f) {
    plane_of_face[now.source[f]] = held.plane_of_face[f];
    noticed[now.source[f]] = held.noticed[f];
  }
  held.plane_of_face = std::move(plane_of_face);
  held.noticed = std::move(noticed);
  return held;
}

}  // namespace

CollapseResult collapse(const CollapseInput& input) {
  Remainder now = start(input);
  const auto surface = input.counting();
  const std::vector<Face> bounded = now.faces;
  const auto bounded_label = select<Index>(input.label, now.source);
  const bool same = bounded.size() == surface.size() && input.fill_count == 0;
  CollapseResult total;
  const HeldFacets held = hold_facets(input, now);
  const Walls walls(now.points, now.faces, held.flat, input.tolerance);
  collapse_blocks(input, held, walls, now, total);
  const auto label = select<Index>(input.label, now.source);
  const auto pinned = select<std::uint8_t>(input.pinned, now.source);
  const auto planes = select<Index>(held.plane_of_face, now.source);
  const auto noticed = select<double>(held.noticed, now.source);
  const std::vector<std::uint8_t> none(now.points.size(), 0);
  const RemainingSurface left{input.points,    surface,        bounded,      bounded_label,  now.points,
                              now.faces,       label,          pinned,       none,           {},
                              input.tolerance, input.decimals, input.single, input.progress, input.fixed,
                              planes,          held.planes,    noticed,      walls};
  Collapser collapser(left);
  CollapseResult result = collapser.run();
  result.holder = collapser.holders();
  if (!same || result.accepted + result.moved + total.accepted + total.moved > 0)
    result.deviation = collapser.deviation(result);
  for (Index& f : result.source) f = now.source[f];
  for (std::size_t i = 0; i < total.refusals.size(); ++i) result.refusals[i] += total.refusals[i];
  result.accepted += total.accepted;
  result.moved += total.moved;
  return result;
}

}  // namespace bldsimp
