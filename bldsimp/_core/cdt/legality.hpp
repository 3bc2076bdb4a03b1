// Decide whether to swap a diagonal: the Delaunay criterion of Triangulator, its ties and its ghosts.
// Internal to the triangulation; inline, since insertion spends most of its time here.
#pragma once

#include "cdt/cdt.hpp"

namespace bldsimp {

// Whether the edge wants to be flipped. A ghost's circle is the open half-plane beyond its hull edge.
template <bool Marked>
bool Triangulator::wants_flip(Index h) const {
  if constexpr (Marked)
    if (mesh_.mark(h) >= 0) return false;
  const Index p = mesh_.apex(h), a = mesh_.origin(h), b = mesh_.target(h), q = mesh_.apex(mesh_.twin(h));
  if ((p | a | b | q) < 0) {  // `infinite` is the only negative vertex
    if (p < 0 || q < 0) return false;
    if (a < 0) return orient2d(site_[b], site_[p], site_[q]) > 0;
    return orient2d(site_[p], site_[a], site_[q]) > 0;
  }
  if (!lift_.empty()) return lifted_wants_flip(p, a, b, q);
  const int side = incircle(site_[p], site_[a], site_[b], site_[q]);
  return side > 0 || (side == 0 && holds_least(p, a, b, q));
}

// Swaps diagonals until the edges around a new vertex, which are on the stack, are Delaunay.
template <bool Marked>
void Triangulator::legalize_star() {
  while (!stack_.empty()) {
    const Index h = stack_.back();
    if (!wants_flip<Marked>(h)) {
      stack_.pop_back();
      continue;
    }
    const Index other = mesh_.twin(h);
    mesh_.flip<Marked>(h);
    ++statistics_.flips;
    stack_.push_back(Mesh2d::next(other));  // h itself is now the other edge opposite the vertex
  }
}

// Puts a site into the net and returns a halfedge that leaves it.
template <bool Marked>
Index Triangulator::insert(Index site, Location location) {
  std::array<Index, 4> rim;
  const int sides = mesh_.star<Marked>(site, location.halfedge, location.place == Place::on_edge, rim);
  stack_.assign(rim.begin(), rim.begin() + sides);
  legalize_star<Marked>();
  return Mesh2d::prev(rim[0]);
}

}  // namespace bldsimp
