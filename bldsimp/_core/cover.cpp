#include "cover.hpp"

#include <algorithm>
#include <bit>

namespace bldsimp {
namespace {

constexpr double kFinest = 1.0 / 64;  // share of the limit: pieces shorter than this are not halved again

}  // namespace

Cover::Cover(std::span<const Vec3> points, std::span<const Face> surface, std::span<const Face> slots, double limit)
    : limit_(limit), relying_(slots.size()) {
  if (slots.empty()) return;
  const FaceTree tree(points, slots);
  pieces_.reserve(surface.size());
  for (const auto& [a, b, c] : surface) pieces_.push_back({{points[a], points[b], points[c]}, -1, -1, -1});
  Index nearest = 0;
  for (std::size_t f = 0; f < surface.size(); ++f) place(static_cast<Index>(f), tree, nearest, limit_ * kFinest);
  std::sort(unproven_.begin(), unproven_.end());
  unproven_.erase(std::unique(unproven_.begin(), unproven_.end()), unproven_.end());
}

void Cover::place(Index piece, const FaceTree& tree, Index& nearest, double finest) {
  const auto corners = pieces_[piece].corners;
  const auto& [a, b, c] = corners;
  const double middle = tree.distance((1.0 / 3) * (a + b + c), nearest);
  const double most = std::max({tree.to_face(a, nearest), tree.to_face(b, nearest), tree.to_face(c, nearest)});
  if (most > limit_ && longest_side(corners) >= finest && middle <= limit_) {
    split(piece);
    const Index child = pieces_[piece].child;
    place(child, tree, nearest, finest);
    place(child + 1, tree, nearest, finest);
    return;
  }
  if (most > limit_) unproven_.push_back(nearest);
  pieces_[piece].slot = nearest;
  relying_[nearest].push_back(piece);
}

void Cover::split(Index piece) {
  Index child;
  if (free_.empty()) {
    child = static_cast<Index>(pieces_.size());
    pieces_.resize(pieces_.size() + 2);
  } else {
    child = free_.back();
    free_.pop_back();
  }
  const auto halves = halved(pieces_[piece].corners);
  for (int i = 0; i < 2; ++i) pieces_[child + i] = {halves[i], piece, -1, -1};
  pieces_[piece].child = child;
  pieces_[piece].slot = -1;
}

void Cover::gather(std::span<const Index> old) {
  gathered_.clear();
  for (const Index slot : old) {
    auto& relying = relying_[slot];
    std::sort(relying.begin(), relying.end());
    relying.erase(std::unique(relying.begin(), relying.end()), relying.end());
    std::erase_if(relying, [&](Index piece) { return pieces_[piece].child >= 0 || pieces_[piece].slot != slot; });
    gathered_.insert(gathered_.end(), relying.begin(), relying.end());
  }
}

Cover::Mask Cover::mask(Vec3 p, std::span<const Holder> holders) const {
  Mask found = 0;
  for (std::size_t i = 0; i < holders.size(); ++i)
    if (holders[i].triangle.squared_distance(p) <= limit_ * limit_) found |= Mask{1} << i;
  return found;
}

bool Cover::finds(std::span<const Index> old, std::span<const Holder> holders) {
  if (holders.empty()) return false;
  holders = holders.first(std::min(holders.size(), most_holders));
  gather(old);
  plan_.clear();
  for (const Index piece : gathered_) {
    const auto& corners = pieces_[piece].corners;
    std::array<Mask, 3> masks;
    for (int i = 0; i < 3; ++i)
      if (masks[i] = mask(corners[i], holders); !masks[i]) return false;
    if (!settle(corners, masks, holders)) return false;
  }
  return true;
}

bool Cover::settle(const Piece3& corners, const std::array<Mask, 3>& masks, std::span<const Holder> holders) {
  if (const Mask common = masks[0] & masks[1] & masks[2]) {
    plan_.push_back(holders[std::countr_zero(common)].slot);
    return true;
  }
  const std::array<double, 3> sides{length(corners[1] - corners[0]), length(corners[2] - corners[1]),
                                    length(corners[0] - corners[2])};
  const std::size_t i = std::max_element(sides.begin(), sides.end()) - sides.begin();
  if (sides[i] < limit_ * kFinest) return false;
  const auto halves = halved(corners);
  const Mask middle = mask(halves[0][1], holders);
  if (!middle) return false;
  plan_.push_back(kSplit);
  return settle(halves[0], {masks[i], middle, masks[(i + 2) % 3]}, holders) &&
         settle(halves[1], {middle, masks[(i + 1) % 3], masks[(i + 2) % 3]}, holders);
}

void Cover::commit(std::span<const Index> old) {
  for (const Index slot : old) relying_[slot].clear();
  moved_.clear();
  std::size_t step = 0;
  for (const Index piece : gathered_) assign(piece, step);
  for (const Index piece : moved_) join(piece);
}

void Cover::assign(Index piece, std::size_t& step) {
  const Index slot = plan_[step++];
  if (slot == kSplit) {
    split(piece);
    const Index child = pieces_[piece].child;
    assign(child, step);
    assign(child + 1, step);
    return;
  }
  pieces_[piece].slot = slot;
  relying_[slot].push_back(piece);
  moved_.push_back(piece);
}

// Corners of a piece are corners of its halves, so the face that holds both holds it.
void Cover::join(Index piece) {
  for (;;) {
    const Piece& own = pieces_[piece];
    const Index parent = own.parent, slot = own.slot;
    if (parent < 0 || slot < 0 || own.child >= 0) return;
    const Index first = pieces_[parent].child;
    if (first != piece && first + 1 != piece) return;
    const Piece& other = pieces_[first + (first == piece)];
    if (other.child >= 0 || other.slot != slot) return;
    for (int i = 0; i < 2; ++i) pieces_[first + i] = {{}, -1, -1, -1};
    free_.push_back(first);
    pieces_[parent].child = -1;
    pieces_[parent].slot = slot;
    relying_[slot].push_back(parent);
    piece = parent;
  }
}

}  // namespace bldsimp
