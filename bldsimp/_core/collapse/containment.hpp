// Keep the proof that a surface lies within a limit of another one that keeps changing.
#pragma once

#include "mesh/cells.hpp"
#include "mesh/distances.hpp"

namespace bldsimp {

// A triangle that could hold pieces, and the index of the face that it belongs to.
struct Holder {
  Index slot;
  FramedTriangle triangle;
};

// The surface is cut into pieces, each within the limit of one single face of the other; the distance to one face is
// greatest at a corner, so few distances prove a piece. Pieces are cut along the edges of the faces that hold them,
// into cells, and joined again where one face holds both parts; many near one another that one face holds are proven by
// the corners of a box around them, so that a proof costs what lies along the edges of the faces and not what lies
// between. `unproven` lists the slots of pieces that no face holds from the start.
class ContainmentProof {
 public:
  static constexpr std::size_t most_holders = 64;

  // The surface is over `points`, and in `order` its faces are mostly beside near ones, as in a tree over them; the
  // faces that hold it are over `positions`.
  ContainmentProof(Points points, Faces surface, Indices order, Points positions, Faces slots, double limit);

  // Slots that something relies on although it is farther than the limit.
  const std::vector<Index>& unproven() const { return unproven_; }

  // Whether all that relies on `old` slots is held by the holders (the first 64 count); remembers how.
  bool finds(Indices old, std::span<const Holder> holders);

  // A corner of a piece that no holder reached when `finds` was last false; of no piece where that was not why.
  struct UnheldCorner {
    Index piece = -1;
    Vec3 place;
  };
  const UnheldCorner& unheld() const { return unheld_; }

  // Whether `finds` would fail at this corner again: its piece relies on `old` slots, and no holder reaches it.
  bool stays_unheld(const UnheldCorner& corner, Indices old, std::span<const Holder> holders) const;

  // The slot that holds some of a face of the surface.
  Index slot_of(Index face) const;

  // Calls visit(corners) for all pieces of faces of the surface that rely on a slot.
  template <class Visit>
  void visit(Index slot, Visit visit) {
    for (const Index piece : relying(slot)) visit_faces(piece, visit);
  }

  // Makes what `finds` found last the truth.
  void commit(Indices old, std::span<const Holder> holders);

 private:
  using Mask = std::uint64_t;
  using CornerMasks = std::array<Mask, Cell::most_corners>;
  // A face of the surface, a cell of one, or a group of faces. Groups and what was cut have children, one after the
  // other from `child` on; whichever the proof rests on has a slot, others have -1.
  struct SurfacePiece {
    Index corners = -1;  // where they begin in the pool; of a group the middle of a box and its half axes
    Index parent = -1, child = -1, slot = -1;
    std::uint8_t children = 0, size = 0, depth = 0;
  };

  void place_all(Faces surface, const FaceTree& tree);
  void place(Index piece, const FaceTree& tree, Index nearest);
  void group(Index piece, Points points, Faces faces, std::size_t begin, std::size_t end);
  bool is_group(Index piece) const { return first_group_ <= piece && piece < end_of_groups_; }
  Points corners(Index piece) const { return Points(pool_).subspan(pieces_[piece].corners, pieces_[piece].size); }
  Cell cell(Index piece) const { return {corners(piece), pieces_[piece].depth}; }
  Index store(Points corners);
  void discard(Index piece);
  std::array<Vec3, 8> box(Index piece) const;
  template <class Visit>
  void visit_faces(Index piece, Visit& visit) const {
    if (pieces_[piece].children == 0) {
      const Points at = corners(piece);
      for (std::size_t i = 2; i < at.size(); ++i) visit(Triangle{at[0], at[i - 1], at[i]});
    }
    for (Index i = 0; i < pieces_[piece].children; ++i) visit_faces(pieces_[piece].child + i, visit);
  }
  void split(Index piece, const CellParts& parts);
  const std::vector<Index>& relying(Index slot);
  void gather(Indices old);
  bool held_by_one(Points corners, std::span<const Holder> holders);
  bool prove(Index piece, std::span<const Holder> holders);
  bool settle(const Cell& cell, const CornerMasks& masks, Vec3 normal, std::span<const Holder> holders);
  std::optional<CellParts> cut(const Cell& cell, const CornerMasks& masks, Vec3 normal,
                               std::span<const Holder> holders) const;
  Mask mask(Vec3 p, std::span<const Holder> holders) const;
  Index find_slot(Index piece) const;
  void assign(Index piece, std::size_t& step, std::size_t& cut);
  void rely(Index piece, Index slot);
  void join(Index piece);

  static constexpr Index kSplit = -1;

  double limit_;                      // less what the roundings of cuts may add up to
  std::vector<SurfacePiece> pieces_;  // faces in the order of `place_`, groups, cells
  std::vector<Vec3> pool_;            // corners of pieces
  std::array<std::vector<Index>, Cell::most_corners + 1> free_corners_;  // places in the pool for so many
  Index first_group_ = 0, end_of_groups_ = 0;
  std::vector<Index> place_;                 // of each face of the surface among the pieces
  std::vector<Index> free_;                  // first children of pairs that were joined
  std::vector<FramedTriangle> triangle_;     // of each slot, as it is now
  std::vector<std::vector<Index>> relying_;  // of each slot: pieces, with some that do not any more
  std::vector<Index> unproven_;
  std::vector<Index> gathered_;
  std::vector<Index> plan_;      // slots, or kSplit before those of the children
  std::vector<CellParts> cuts_;  // of cells that the plan splits, in its order
  std::vector<Index> moved_;
  std::size_t last_ = 0;  // holder that held a piece last
  UnheldCorner unheld_;
};

}  // namespace bldsimp
