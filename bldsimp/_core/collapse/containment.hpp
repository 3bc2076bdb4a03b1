// Keep the proof that a surface lies within a limit of another one that keeps changing.
#pragma once

#include "mesh/distances.hpp"
#include "mesh/framed_triangle.hpp"

namespace bldsimp {

// A triangle that could hold pieces, and the index of the face that it belongs to.
struct Holder {
  Index slot;
  FramedTriangle triangle;
};

// The surface is cut into pieces so small that each lies within the limit of one single face of the other; the
// distance to one face is greatest at a corner, so few distances prove a piece. Pieces are halved where faces
// part them and joined again where one face holds both halves; many near one another that one face holds are
// proven by the corners of a box around them, so that a proof costs what lies along the edges of the faces and not
// what lies between. `unproven` lists the slots of pieces that no face holds from the start.
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
  // A face of the surface, a part of one, or a group of faces. Groups and what was halved have children, one after
  // the other from `child` on; whichever the proof rests on has a slot, others have -1.
  struct SurfacePiece {
    std::array<Vec3, 4> shape;  // three corners; of a group the middle of a box and its half axes
    Index parent = -1, child = -1, slot = -1;
    Index children = 0;
  };

  void place_all(Faces surface, const FaceTree& tree);
  void place(Index piece, const FaceTree& tree, Index nearest);
  void group(Index piece, Points points, Faces faces, std::size_t begin, std::size_t end);
  bool is_group(Index piece) const { return first_group_ <= piece && piece < end_of_groups_; }
  Triangle corners(Index piece) const {
    return {pieces_[piece].shape[0], pieces_[piece].shape[1], pieces_[piece].shape[2]};
  }
  std::array<Vec3, 8> box(Index piece) const;
  template <class Visit>
  void visit_faces(Index piece, Visit& visit) const {
    if (pieces_[piece].children == 0) visit(corners(piece));
    for (Index i = 0; i < pieces_[piece].children; ++i) visit_faces(pieces_[piece].child + i, visit);
  }
  void split(Index piece);
  const std::vector<Index>& relying(Index slot);
  void gather(Indices old);
  bool held_by_one(Points corners, std::span<const Holder> holders);
  bool prove(Index piece, std::span<const Holder> holders);
  bool settle(const Triangle& corners, const std::array<Mask, 3>& masks, std::span<const Holder> holders);
  Mask mask(Vec3 p, std::span<const Holder> holders) const;
  void assign(Index piece, std::size_t& step);
  void rely(Index piece, Index slot);
  void join(Index piece);

  static constexpr Index kSplit = -1;

  double limit_;
  std::vector<SurfacePiece> pieces_;  // faces in the order of `place_`, groups, halves
  Index first_group_ = 0, end_of_groups_ = 0;
  std::vector<Index> place_;                 // of each face of the surface among the pieces
  std::vector<Index> free_;                  // first children of pairs that were joined
  std::vector<FramedTriangle> triangle_;     // of each slot, as it is now
  std::vector<std::vector<Index>> relying_;  // of each slot: pieces, with some that do not any more
  std::vector<Index> unproven_;
  std::vector<Index> gathered_;
  std::vector<Index> plan_;  // slots, or kSplit before those of the children
  std::vector<Index> moved_;
  std::size_t last_ = 0;  // holder that held a piece last
};

}  // namespace bldsimp
