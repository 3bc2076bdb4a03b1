#include "collapse/containment.hpp"

#include <bit>

#include "mesh/box_tree.hpp"
#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

// A group is of no use if its box is thicker than this many times the limit: hardly a face would hold it.
constexpr double kThickest = 2;
constexpr std::size_t kLeastParallel = 4096;

double largest_coordinate(Points points) {
  double most = 0;
  for (const Vec3& p : points) most = std::max({most, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return most;
}

}  // namespace

ContainmentProof::ContainmentProof(Points points, Faces surface, Indices order, Points positions, Faces slots,
                                   double limit)
    : limit_(limit - Cell::most_depth * Cell::rounding * largest_coordinate(points)), place_(surface.size()),
      relying_(slots.size()) {
  if (slots.empty() || surface.empty()) return;
  const FaceTree tree(positions, slots);
  triangle_.reserve(slots.size());
  for (const auto& [a, b, c] : slots) triangle_.emplace_back(positions[a], positions[b], positions[c]);
  pieces_.reserve(2 * surface.size());
  pool_.reserve(5 * surface.size());
  for (const Index face : order) {
    place_[face] = static_cast<Index>(pieces_.size());
    pieces_.push_back({store(corners_of(surface[face], points)), -1, -1, -1, 0, 3, 0});
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
  const auto children = static_cast<std::uint8_t>(few ? end - begin : 2);
  if (!few) pieces_.resize(pieces_.size() + 2);
  SurfacePiece& own = pieces_[piece];
  own.corners = store(shape);
  own.size = static_cast<std::uint8_t>(shape.size());
  own.child = child;
  own.children = children;
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
          tree.distance(cell(static_cast<Index>(f)).middle(), nearest[f]);
        }
      },
      kLeastParallel);
  for (std::size_t f = 0; f < surface.size(); ++f) place(static_cast<Index>(f), tree, nearest[f]);
  sort_unique(unproven_);
  for (Index f = 0; f < first_group_; ++f) join(f);
}

// `nearest` is the slot nearest to the middle of the piece.
void ContainmentProof::place(Index piece, const FaceTree& tree, Index nearest) {
  const Cell own = cell(piece);
  const FramedTriangle& face = triangle_[nearest];
  Vec3 worst = own[0];
  double most = -1;
  for (const Vec3& p : own.corners())
    if (const double square = face.squared_distance(p); square > most) most = square, worst = p;
  const bool held = most <= limit_ * limit_;
  if (!held && own.diameter() >= limit_ * FaceTree::finest && face.within(own.middle(), limit_)) {
    Index other = nearest;
    tree.distance(worst, other);
    if (const auto parts = cut_cell(own, {worst, find_normal(own, face), face, triangle_[other]}, limit_)) {
      split(piece, *parts);
      const Index child = pieces_[piece].child;
      for (int i = 0; i < 2; ++i) {
        Index near = i == 0 ? nearest : other;
        tree.distance(cell(child + i).middle(), near);
        place(child + i, tree, near);
      }
      return;
    }
  }
  if (!held) unproven_.push_back(nearest);
  rely(piece, nearest);
}

// That a piece or what it is part of relies on, or -1.
Index ContainmentProof::find_slot(Index piece) const {
  for (Index up = piece; up >= 0; up = pieces_[up].parent)
    if (pieces_[up].slot >= 0) return pieces_[up].slot;
  return -1;
}

bool ContainmentProof::stays_unheld(const UnheldCorner& corner, Indices old, std::span<const Holder> holders) const {
  // Pieces are joined and their places taken by others: whatever is there now counts if it has the corner.
  if (pieces_[corner.piece].size == 0) return false;
  const Points at = corners(corner.piece);
  if (std::find(at.begin(), at.end(), corner.place) == at.end()) return false;
  const Index slot = find_slot(corner.piece);
  if (slot < 0 || std::find(old.begin(), old.end(), slot) == old.end()) return false;
  holders = holders.first(std::min(holders.size(), most_holders));
  return std::none_of(holders.begin(), holders.end(),
                      [&](const Holder& holder) { return holder.triangle.within(corner.place, limit_); });
}

Index ContainmentProof::slot_of(Index face) const {
  Index piece = place_[face];
  if (const Index slot = find_slot(piece); slot >= 0) return slot;
  while (pieces_[piece].slot < 0) piece = pieces_[piece].child;
  return pieces_[piece].slot;
}

void ContainmentProof::rely(Index piece, Index slot) {
  pieces_[piece].slot = slot;
  relying_[slot].push_back(piece);
}

std::array<Vec3, 8> ContainmentProof::box(Index piece) const {
  const Points shape = corners(piece);
  const Vec3 middle = shape[0], x = shape[1], y = shape[2], z = shape[3];
  std::array<Vec3, 8> found;
  // Opposite corners first: they tell soonest that no face holds all.
  for (int i = 0; i < 4; ++i) {
    const Vec3 way = x + (i & 1 ? -1.0 : 1.0) * y + (i & 2 ? -1.0 : 1.0) * z;
    found[2 * i] = middle + way;
    found[2 * i + 1] = middle - way;
  }
  return found;
}

// Cells have three to eight corners: each takes no more of the pool than it needs, and leaves it to the next of as
// many.
Index ContainmentProof::store(Points corners) {
  auto& unused = free_corners_[corners.size()];
  if (unused.empty()) {
    pool_.insert(pool_.end(), corners.begin(), corners.end());
    return static_cast<Index>(pool_.size() - corners.size());
  }
  const Index begin = unused.back();
  unused.pop_back();
  std::copy(corners.begin(), corners.end(), pool_.begin() + begin);
  return begin;
}

void ContainmentProof::discard(Index piece) {
  free_corners_[pieces_[piece].size].push_back(pieces_[piece].corners);
  pieces_[piece] = {};
}

void ContainmentProof::split(Index piece, const CellParts& parts) {
  Index child;
  if (free_.empty()) {
    child = static_cast<Index>(pieces_.size());
    pieces_.resize(pieces_.size() + 2);
  } else {
    child = free_.back();
    free_.pop_back();
  }
  for (const auto& [at, part] : {std::pair(child, &parts.rest), std::pair(child + 1, &parts.beyond)})
    pieces_[at] = {store(part->corners()),
                   piece,
                   -1,
                   -1,
                   0,
                   static_cast<std::uint8_t>(part->size()),
                   static_cast<std::uint8_t>(part->depth())};
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
  cuts_.clear();
  last_ = 0;
  unheld_ = {};
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
  if (held_by_one(corners(piece), holders)) return true;
  const Cell own = cell(piece);
  CornerMasks masks;
  for (int i = 0; i < own.size(); ++i)
    if (masks[i] = mask(own[i], holders); !masks[i]) {
      unheld_ = {piece, own[i]};
      return false;
    }
  return settle(own, masks, find_normal(own, holders[0].triangle), holders);
}

bool ContainmentProof::settle(const Cell& cell, const CornerMasks& masks, Vec3 normal,
                              std::span<const Holder> holders) {
  Mask common = masks[0];
  for (int i = 1; i < cell.size(); ++i) common &= masks[i];
  if (common) {
    plan_.push_back(holders[std::countr_zero(common)].slot);
    return true;
  }
  if (cell.diameter() < limit_ * FaceTree::finest) return false;
  const auto parts = cut(cell, masks, normal, holders);
  if (!parts) return false;
  // Few corners are new, and some of them are those of both parts.
  std::array<CornerMasks, 2> own;
  const Cell* cells[] = {&cell, &parts->rest};
  const CornerMasks* known[] = {&masks, &own[0]};
  for (int k = 0; k < 2; ++k) {
    const Cell& part = k == 0 ? parts->rest : parts->beyond;
    for (int i = 0; i < part.size(); ++i) {
      own[k][i] = 0;
      for (int from = 0; from <= k && !own[k][i]; ++from)
        for (int j = 0; j < cells[from]->size() && !own[k][i]; ++j)
          if ((*cells[from])[j] == part[i]) own[k][i] = (*known[from])[j];
      if (!own[k][i]) own[k][i] = mask(part[i], holders);
      if (!own[k][i]) return false;
    }
  }
  plan_.push_back(kSplit);
  cuts_.push_back(*parts);
  return settle(parts->rest, own[0], normal, holders) && settle(parts->beyond, own[1], normal, holders);
}

// The holder with the most corners keeps them, of several the one nearest to the middle; what it does not hold is cut
// off. The others' part goes to the one with the most corners beside the worst.
std::optional<CellParts> ContainmentProof::cut(const Cell& cell, const CornerMasks& masks, Vec3 normal,
                                               std::span<const Holder> holders) const {
  Mask any = 0;
  for (int i = 0; i < cell.size(); ++i) any |= masks[i];
  const auto count = [&](int holder) {
    int corners = 0;
    for (int i = 0; i < cell.size(); ++i) corners += static_cast<int>(masks[i] >> holder & 1);
    return corners;
  };
  const Vec3 middle = cell.middle();
  int best = -1, other = -1, worst = -1, most = 0;
  double least = 0, far = -1;
  for (Mask left = any; left; left &= left - 1) {
    const int holder = std::countr_zero(left), corners = count(holder);
    if (corners < most) continue;
    const double square = holders[holder].triangle.squared_distance(middle);
    if (corners > most || square < least) most = corners, best = holder, least = square;
  }
  const FramedTriangle& own = holders[best].triangle;
  for (int i = 0; i < cell.size(); ++i) {
    if (masks[i] >> best & 1) continue;
    if (const double square = own.squared_distance(cell[i]); square > far) far = square, worst = i;
  }
  most = 0;
  for (Mask left = masks[worst]; left; left &= left - 1)
    if (const int holder = std::countr_zero(left), corners = count(holder); corners > most)
      most = corners, other = holder;
  return cut_cell(cell, {cell[worst], normal, own, holders[other].triangle}, limit_);
}

void ContainmentProof::commit(Indices old, std::span<const Holder> holders) {
  for (const Index slot : old) relying_[slot].clear();
  for (const Holder& holder : holders) triangle_[holder.slot] = holder.triangle;
  moved_.clear();
  std::size_t step = 0, cut = 0;
  for (const Index piece : gathered_) assign(piece, step, cut);
  for (const Index piece : moved_) join(piece);
}

void ContainmentProof::assign(Index piece, std::size_t& step, std::size_t& cut) {
  const Index slot = plan_[step++];
  if (slot != kSplit) {
    rely(piece, slot);
    moved_.push_back(piece);
    return;
  }
  if (is_group(piece))
    pieces_[piece].slot = -1;
  else
    split(piece, cuts_[cut++]);
  const Index child = pieces_[piece].child, children = pieces_[piece].children;
  for (Index i = 0; i < children; ++i) assign(child + i, step, cut);
}

// Corners of a piece are corners of its parts, so the face that holds both holds it; a box has corners of its own.
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
      for (Index i = 0; i < 2; ++i) discard(whole.child + i);
      free_.push_back(whole.child);
      whole.child = -1;
      whole.children = 0;
    }
    rely(parent, slot);
    piece = parent;
  }
}

}  // namespace bldsimp
