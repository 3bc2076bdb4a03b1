// The standing proof that a surface lies within a limit of another one that keeps changing.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "distances.hpp"
#include "framed.hpp"

namespace bldsimp {

// A triangle that could hold pieces, and the index of the face that it belongs to.
struct Holder {
  Index slot;
  FramedTriangle triangle;
};

// The surface is cut into pieces so small that each lies within the limit of one single face of the other; the
// distance to one face is greatest at a corner, so three distances prove a piece. Pieces are halved where faces
// part them and joined again where one face holds both halves. What no face holds from the start is told, and
// relied on as it is.
class Cover {
 public:
  using Piece3 = std::array<Vec3, 3>;
  static constexpr std::size_t most_holders = 64;

  Cover(std::span<const Vec3> points, std::span<const Face> surface, std::span<const Face> slots, double limit);

  // Slots that something relies on although it is farther than the limit.
  const std::vector<Index>& unproven() const { return unproven_; }

  // Whether all that relies on `old` slots is held by the holders (the first 64 count); remembers how.
  bool finds(std::span<const Index> old, std::span<const Holder> holders);

  // The slot that holds some of a face of the surface.
  Index slot_of(Index face) const {
    while (pieces_[face].child >= 0) face = pieces_[face].child;
    return pieces_[face].slot;
  }

  // Makes what `finds` found last the truth.
  void commit(std::span<const Index> old);

  std::size_t piece_count() const { return pieces_.size(); }

 private:
  struct Piece {
    Piece3 corners;
    Index parent, child, slot;  // the second child follows the first; -1 for none; slot of a leaf only
  };
  using Mask = std::uint64_t;

  void place(Index piece, const FaceTree& tree, Index& nearest, double finest);
  void split(Index piece);
  void gather(std::span<const Index> old);
  bool settle(const Piece3& corners, const std::array<Mask, 3>& masks, std::span<const Holder> holders);
  Mask mask(Vec3 p, std::span<const Holder> holders) const;
  void assign(Index piece, std::size_t& step);
  void join(Index piece);

  static constexpr Index kSplit = -1;

  double limit_;
  std::vector<Piece> pieces_;
  std::vector<Index> free_;                   // first children of pairs that were joined
  std::vector<std::vector<Index>> relying_;   // of each slot: pieces, with some that do not any more
  std::vector<Index> unproven_;
  std::vector<Index> gathered_;
  std::vector<Index> plan_;  // slots, or kSplit before those of both halves
  std::vector<Index> moved_;
};

}  // namespace bldsimp
