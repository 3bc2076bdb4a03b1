#include "collapse/containment.hpp"

#include <bit>

#include "mesh/box_tree.hpp"
#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

// A group is of no use if its box is thicker than this many times the limit: hardly a face would hold it.
constexpr double kThickest = 2;
constexpr std::size_t kLeastParallel = 4096;

}  // namespace

ContainmentProof::ContainmentProof(Points points, Faces surface, Indices order, Points positions, Faces slots,
                                   double limit)
    : limit_(limit), place_(surface.size()), relying_(slots.size()) {
  if (slots.empty() || surface.empty()) return;
  const FaceTree tree(positions, slots);
  triangle_.reserve(slots.size());
  for (const auto& [a, b, c] : slots) triangle_.emplace_back(positions[a], positions[b], positions[c]);
  pieces_.reserve(2 * surface.size());
  for (const Index face : order) {
    const auto [a, b, c] = corners_of(surface[face], points);
    place_[face] = static_cast<Index>(pieces_.size());
    pieces_.push_back({{a, b, c, {}}});
  }
  std::vector<Face> ordered;
  ordered.reserve(surface.size());
  for (const Index face : order) ordered.push_back(surface[face]);
  first_group_ = static_cast<Index>(pieces_.size());
  pieces_.emplace_back();
  group(first_group_, points, ordered, 0, ordered.size());
  end_of_groups_ = static_cast<Index>(pieces_.size());
  place_all(ordered, tree);
}

// Boxes lie along the longest way through their faces, and square to the faces' mean normal.
void ContainmentProof::group(Index piece, Points points, Faces faces, std::size_t begin, std::size_t end) {
  const Vec3 start = points[faces[begin][0]];
  Vec3 normal{0, 0, 0}, far = start;
  for (std::size_t f = begin; f < end; ++f) {
    const auto& [a, b, c] = faces[f];
    normal = normal + cross(points[b] - points[a], points[c] - points[a]);
    for (const Index p : faces[f])
      if (length(points[p] - start) > length(far - start)) far = points[p];
  }
  const Vec3 u = normalize(far - start);
  Vec3 n = normalize(normal - dot(normal, u) * u);
  if (n == Vec3{0, 0, 0}) n = square_to(u);
  const Triangle axes{u, n, cross(u, n)};
  std::array<double, 3> low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-low[0]);
  for (std::size_t f = begin; f < end; ++f)
    for (const Index p : faces[f])
      for (int i = 0; i < 3; ++i) {
        const double at = dot(points[p] - start, axes[i]);
        low[i] = std::min(low[i], at), high[i] = std::max(high[i], at);
      }
  std::array<Vec3, 4> shape{start};
  for (int i = 0; i < 3; ++i) {
    shape[0] = shape[0] + (low[i] + high[i]) / 2 * axes[i];
    shape[i + 1] = (high[i] - low[i]) / 2 * axes[i];
  }
  const bool useful = high[1] - low[1] <= kThickest * limit_;
  const std::size_t half = begin + (end - begin) / 2;
  const bool few = end - begin <= static_cast<std::size_t>(BoxTree::few);
  const Index child = static_cast<Index>(few ? begin : pieces_.size());
  const Index children = static_cast<Index>(few ? end - begin : 2);
  if (!few) pieces_.resize(pieces_.size() + 2);
  pieces_[piece].shape = shape;
  pieces_[piece].child = child;
  pieces_[piece].children = children;
  if (useful)
    for (Index i = 0; i < children; ++i) pieces_[child + i].parent = piece;
  if (few) return;
  group(child, points, faces, begin, half);
  group(child + 1, points, faces, half, end);
}

void ContainmentProof::place_all(Faces surface, const FaceTree& tree) {
  std::vector<Index> nearest(surface.size());
  parallel_for(
      surface.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
          nearest[f] = f > begin ? nearest[f - 1] : 0;
          tree.distance(centroid(corners(static_cast<Index>(f))), nearest[f]);
        }
      },
      kLeastParallel);
  for (std::size_t f = 0; f < surface.size(); ++f) place(static_cast<Index>(f), tree, nearest[f]);
  sort_unique(unproven_);
  for (Index f = 0; f < first_group_; ++f) join(f);
}

// `nearest` is the slot nearest to the middle of the piece.
void ContainmentProof::place(Index piece, const FaceTree& tree, Index nearest) {
  const auto [a, b, c] = corners(piece);
  const double most = std::max({tree.to_face(a, nearest), tree.to_face(b, nearest), tree.to_face(c, nearest)});
  if (most > limit_ && longest_side(corners(piece)) >= limit_ * FaceTree::finest &&
      tree.to_face(centroid({a, b, c}), nearest) <= limit_) {
    split(piece);
    for (int i = 0; i < 2; ++i) {
      const Index child = pieces_[piece].child + i;
      Index near = nearest;
      tree.distance(centroid(corners(child)), near);
      place(child, tree, near);
    }
    return;
  }
  if (most > limit_) unproven_.push_back(nearest);
  rely(piece, nearest);
}

Index ContainmentProof::slot_of(Index face) const {
  Index piece = place_[face];
  for (Index up = piece; up >= 0; up = pieces_[up].parent)
    if (pieces_[up].slot >= 0) return pieces_[up].slot;
  while (pieces_[piece].slot < 0) piece = pieces_[piece].child;
  return pieces_[piece].slot;
}

void ContainmentProof::rely(Index piece, Index slot) {
  pieces_[piece].slot = slot;
  relying_[slot].push_back(piece);
}

std::array<Vec3, 8> ContainmentProof::box(Index piece) const {
  const auto& [middle, x, y, z] = pieces_[piece].shape;
  std::array<Vec3, 8> found;
  // Opposite corners first: they tell soonest that no face holds all.
  for (int i = 0; i < 4; ++i) {
    const Vec3 way = x + (i & 1 ? -1.0 : 1.0) * y + (i & 2 ? -1.0 : 1.0) * z;
    found[2 * i] = middle + way;
    found[2 * i + 1] = middle - way;
  }
  return found;
}

void ContainmentProof::split(Index piece) {
  Index child;
  if (free_.empty()) {
    child = static_cast<Index>(pieces_.size());
    pieces_.resize(pieces_.size() + 2);
  } else {
    child = free_.back();
    free_.pop_back();
  }
  const auto halves = halve(corners(piece));
  for (int i = 0; i < 2; ++i) {
    const auto& [a, b, c] = halves[i];
    pieces_[child + i] = {{a, b, c, {}}, piece};
  }
  pieces_[piece].child = child;
  pieces_[piece].children = 2;
  pieces_[piece].slot = -1;
}

const std::vector<Index>& ContainmentProof::relying(Index slot) {
  auto& own = relying_[slot];
  sort_unique(own);
  std::erase_if(own, [&](Index piece) { return pieces_[piece].slot != slot; });
  return own;
}

void ContainmentProof::gather(Indices old) {
  gathered_.clear();
  for (const Index slot : old) {
    append(gathered_, relying(slot));
  }
}

ContainmentProof::Mask ContainmentProof::mask(Vec3 p, std::span<const Holder> holders) const {
  Mask found = 0;
  for (std::size_t i = 0; i < holders.size(); ++i)
    if (holders[i].triangle.within(p, limit_)) found |= Mask{1} << i;
  return found;
}

bool ContainmentProof::finds(Indices old, std::span<const Holder> holders) {
  if (holders.empty()) return false;
  holders = holders.first(std::min(holders.size(), most_holders));
  gather(old);
  plan_.clear();
  last_ = 0;
  return std::all_of(gathered_.begin(), gathered_.end(), [&](Index piece) { return prove(piece, holders); });
}

// One holder for all corners, the last one first: neighbors mostly have the same.
bool ContainmentProof::held_by_one(Points corners, std::span<const Holder> holders) {
  const auto holds = [&](std::size_t i) {
    return std::all_of(corners.begin(), corners.end(),
                       [&](const Vec3& corner) { return holders[i].triangle.within(corner, limit_); });
  };
  for (std::size_t i = 0; i < holders.size(); ++i) {
    const std::size_t guess = i == 0 ? last_ : i <= last_ ? i - 1 : i;
    if (!holds(guess)) continue;
    last_ = guess;
    plan_.push_back(holders[guess].slot);
    return true;
  }
  return false;
}

bool ContainmentProof::prove(Index piece, std::span<const Holder> holders) {
  if (is_group(piece)) {
    if (held_by_one(box(piece), holders)) return true;
    plan_.push_back(kSplit);
    const SurfacePiece& own = pieces_[piece];
    for (Index i = 0; i < own.children; ++i)
      if (!prove(own.child + i, holders)) return false;
    return true;
  }
  const Triangle own = corners(piece);
  if (held_by_one(own, holders)) return true;
  std::array<Mask, 3> masks;
  for (int i = 0; i < 3; ++i)
    if (masks[i] = mask(own[i], holders); !masks[i]) return false;
  return settle(own, masks, holders);
}

bool ContainmentProof::settle(const Triangle& corners, const std::array<Mask, 3>& masks,
                              std::span<const Holder> holders) {
  if (const Mask common = masks[0] & masks[1] & masks[2]) {
    plan_.push_back(holders[std::countr_zero(common)].slot);
    return true;
  }
  if (longest_side(corners) < limit_ * FaceTree::finest) return false;
  const std::size_t i = longest_at(corners);
  const auto halves = halve(corners);
  const Mask middle = mask(halves[0][1], holders);
  if (!middle) return false;
  plan_.push_back(kSplit);
  return settle(halves[0], {masks[i], middle, masks[(i + 2) % 3]}, holders) &&
         settle(halves[1], {middle, masks[(i + 1) % 3], masks[(i + 2) % 3]}, holders);
}

void ContainmentProof::commit(Indices old, std::span<const Holder> holders) {
  for (const Index slot : old) relying_[slot].clear();
  for (const Holder& holder : holders) triangle_[holder.slot] = holder.triangle;
  moved_.clear();
  std::size_t step = 0;
  for (const Index piece : gathered_) assign(piece, step);
  for (const Index piece : moved_) join(piece);
}

void ContainmentProof::assign(Index piece, std::size_t& step) {
  const Index slot = plan_[step++];
  if (slot != kSplit) {
    rely(piece, slot);
    moved_.push_back(piece);
    return;
  }
  if (is_group(piece))
    pieces_[piece].slot = -1;
  else
    split(piece);
  const Index child = pieces_[piece].child, children = pieces_[piece].children;
  for (Index i = 0; i < children; ++i) assign(child + i, step);
}

// Corners of a piece are corners of its halves, so the face that holds both holds it; a box has corners of its own.
void ContainmentProof::join(Index piece) {
  for (;;) {
    const Index parent = pieces_[piece].parent, slot = pieces_[piece].slot;
    if (parent < 0 || slot < 0) return;
    SurfacePiece& whole = pieces_[parent];
    for (Index i = 0; i < whole.children; ++i)
      if (pieces_[whole.child + i].slot != slot) return;
    if (is_group(parent)) {
      const auto around = box(parent);
      if (std::any_of(around.begin(), around.end(),
                      [&](const Vec3& corner) { return !triangle_[slot].within(corner, limit_); }))
        return;
      for (Index i = 0; i < whole.children; ++i) pieces_[whole.child + i].slot = -1;
    } else {
      for (Index i = 0; i < 2; ++i) pieces_[whole.child + i] = {};
      free_.push_back(whole.child);
      whole.child = -1;
      whole.children = 0;
    }
    rely(parent, slot);
    piece = parent;
  }
}

}  // namespace bldsimp
