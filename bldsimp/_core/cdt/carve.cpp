// Step 6 and the result: carves away what lies outside the rings, and numbers what stays.

#include "cdt/cdt.hpp"

namespace bldsimp {

// Labels each triangle with the least number of pieces, counted where an odd number of segments runs
// along them, between it and the outside. For closed rings its parity is that of every way out, so
// this is the flood fill that counts ring crossings; for open chains it is still unique.
void Triangulator::number_layers() {
  layer_.clear();
  next_layer_.clear();
  for (Index t = 0; t < mesh_.size(); ++t) {
    mesh_.label(t) = mesh_.ghost(t) ? 0 : -1;
    if (mesh_.ghost(t)) layer_.push_back(t);
  }
  for (Index depth = 0; !layer_.empty(); ++depth) {
    while (!layer_.empty()) {
      const Index t = layer_.back();
      layer_.pop_back();
      for (Index h = 4 * t; h < 4 * t + 3; ++h) {
        const Index across = Mesh2d::triangle(mesh_.twin(h));
        if (mesh_.label(across) >= 0) continue;
        const Index uses = mesh_.mark(h);
        if (uses >= 0 && use_[uses].count % 2 == 1) {
          next_layer_.push_back(across);
          continue;
        }
        mesh_.label(across) = depth;
        layer_.push_back(across);
      }
    }
    for (const Index t : next_layer_)
      if (mesh_.label(t) < 0) {
        mesh_.label(t) = depth + 1;
        layer_.push_back(t);
      }
    next_layer_.clear();
  }
}

void Triangulator::emit(bool carve) {
  if (carve && use_.empty()) return;
  if (carve) number_layers();
  Index count = 0;
  for (Index t = 0; t < mesh_.size(); ++t) {
    const bool kept = !mesh_.ghost(t) && (!carve || mesh_.label(t) % 2 == 1);
    mesh_.label(t) = kept ? count++ : -1;
  }
  triangles_.resize(count);
  neighbors_.resize(count);
  for (Index t = 0; t < mesh_.size(); ++t) {
    const Index row = mesh_.label(t);
    if (row < 0) continue;
    for (Index i = 0; i < 3; ++i) {
      triangles_[row][i] = input_[mesh_.origin(4 * t + i)];
      neighbors_[row][(i + 2) % 3] = mesh_.label(Mesh2d::triangle(mesh_.twin(4 * t + i)));
    }
  }
}

// Sorted by segment, and along each from its first end to its second.
void Triangulator::emit_pieces(std::span<const Segment> segments) {
  if (use_.empty()) return;
  for (Index t = 0; t < mesh_.size(); ++t)
    for (Index h = 4 * t; h < 4 * t + 3; ++h) {
      if (h > mesh_.twin(h)) continue;
      for (Index use = mesh_.mark(h); use >= 0; use = use_[use].next)
        pieces_.push_back({input_[mesh_.origin(h)], input_[mesh_.target(h)], use_[use].segment});
    }
  // A bent segment stays within boxes, so it is monotone in x and in y.
  const auto before = [&](Index segment, Index p, Index q) {
    const Point2 &from = points_[segments[segment][0]], &to = points_[segments[segment][1]];
    const Point2 &first = points_[p], &second = points_[q];
    if (first.x != second.x) return (first.x < second.x) == (from.x < to.x);
    return first.y != second.y && (first.y < second.y) == (from.y < to.y);
  };
  for (SegmentPiece& piece : pieces_)
    if (!before(piece.segment, piece.a, piece.b)) std::swap(piece.a, piece.b);
  std::sort(pieces_.begin(), pieces_.end(), [&](const SegmentPiece& p, const SegmentPiece& q) {
    return p.segment != q.segment ? p.segment < q.segment : before(p.segment, p.a, q.a);
  });
}

}  // namespace bldsimp
