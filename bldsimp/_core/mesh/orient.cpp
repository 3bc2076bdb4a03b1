#include "mesh/orient.hpp"

#include "mesh/edges.hpp"
#include "mesh/index_sets.hpp"
#include "mesh/vertical_ray.hpp"

namespace bldsimp {
namespace {

// Sets of faces, each face with the parity of its winding against that of the set's root (its least face).
class Windings {
 public:
  // Twins run opposite ways already: they are joined as they are.
  explicit Windings(Indices twin)
      : parent_(join_across(twin, [](Index, Index) { return true; })), odd_(parent_.size(), 0) {}
  std::pair<Index, bool> find(Index f) {
    bool odd = false;
    while (parent_[f] != f) {
      const Index p = parent_[f];
      odd_[f] ^= odd_[p];
      parent_[f] = parent_[p];
      odd ^= odd_[f] != 0;
      f = parent_[f];
    }
    return {f, odd};
  }
  // Joins two faces that must run the same way, or opposite ways if `against`; false if they cannot.
  bool join(Index f, Index g, bool against) {
    auto [a, a_odd] = find(f);
    auto [b, b_odd] = find(g);
    const bool odd = (a_odd != b_odd) != against;
    if (a == b) return !odd;
    if (a > b) std::swap(a, b);
    parent_[b] = a;
    odd_[b] = odd;
    return true;
  }

 private:
  Array<Index> parent_;
  Array<std::uint8_t> odd_;
};

class Orienter {
 public:
  Orienter(Points points, Faces faces, const Halfedges& halfedges, const CornerRows& rows, Flags fixed)
      : points_(points), faces_(faces), halfedges_(halfedges), rows_(rows), windings_(halfedges.twin), fixed_(fixed),
        component_(faces.size()), turned_(faces.size(), 0) {}

  std::vector<Index> find() {
    join_components();
    turn_against_larger_area();
    find_open_components();
    turn_inside_out();
    std::vector<Index> result;
    for (Index f = 0; f < count(); ++f)
      if (turned_[f]) result.push_back(f);
    return result;
  }

 private:
  Index count() const { return static_cast<Index>(faces_.size()); }
  Vec3 corner(Index f, int i) const { return points_[faces_[f][i]]; }
  Vec3 area_vector(Index f) const { return bldsimp::area_vector(corners_of(faces_[f], points_)); }
  bool runs_forward(Index h) const { return (origin(faces_, h) < target(faces_, h)) != (turned_[h / 3] != 0); }

  void join_components() {
    std::vector<Index> torn;  // faces whose component cannot be oriented
    const auto join = [&](Index h, Index g) {
      if (!windings_.join(h / 3, g / 3, runs_forward(h) == runs_forward(g))) torn.push_back(h / 3);
    };
    halfedges_.for_groups([&](Indices edge) {
      if (edge.size() == 2)
        join(edge[0], edge[1]);
      else
        for_row_mates(edge, faces_, rows_, join);
    });
    for (Index f = 0; f < count(); ++f) {
      const auto [root, odd] = windings_.find(f);
      if (root == f) {
        component_[f] = static_cast<Index>(first_face_.size());
        first_face_.push_back(f);
        may_turn_.push_back(1);
      } else {
        component_[f] = component_[root];
      }
      turned_[f] = odd;
      if (fixed_[f]) may_turn_[component_[f]] = 0;
    }
    closed_.assign(first_face_.size(), 1);
    for (const Index f : torn) may_turn_[component_[f]] = 0;
  }

  void turn_against_larger_area() {
    const bool any = std::any_of(turned_.begin(), turned_.end(), [](std::uint8_t t) { return t != 0; });
    if (!any) return;
    std::vector<double> balance(first_face_.size(), 0);
    for (Index f = 0; f < count(); ++f) balance[component_[f]] += (turned_[f] ? -1 : 1) * length(area_vector(f));
    for (Index f = 0; f < count(); ++f)
      turned_[f] = may_turn_[component_[f]] ? turned_[f] ^ (balance[component_[f]] < 0) : 0;
  }

  // A component is closed if on each of its edges as many of its halfedges run one way as the other.
  void find_open_components() {
    Array<std::uint8_t> grouped(halfedges_.twin.size(), 0);
    std::vector<std::pair<Index, int>> balance;
    halfedges_.for_groups([&](Indices edge) {
      balance.clear();
      for (const Index h : edge) {
        grouped[h] = 1;
        balance.push_back({component_[h / 3], runs_forward(h) ? 1 : -1});
      }
      for_unbalanced(balance, [&](Index c) { closed_[c] = 0; });
    });
    for (Index h = 0; h < 3 * count(); ++h)
      if (halfedges_.twin[h] < 0 && !grouped[h]) closed_[component_[h / 3]] = 0;
  }

  void turn_inside_out() {
    Array<double> part(faces_.size());  // of the volume, from a corner of the component
    parallel_each(faces_.size(), [&](Index f) {
      part[f] = dot(corner(f, 0) - corner(first_face_[component_[f]], 0), area_vector(f));
    });
    std::vector<double> volume(first_face_.size(), 0), magnitude(first_face_.size(), 0);
    for (Index f = 0; f < count(); ++f) {
      volume[component_[f]] += turned_[f] ? -part[f] : part[f];
      magnitude[component_[f]] += std::abs(part[f]);
    }
    std::vector<Index> inside_out;
    for (Index c = 0; c < std::ssize(first_face_); ++c)
      if (closed_[c] && may_turn_[c] && volume[c] < -1e-9 * magnitude[c]) inside_out.push_back(c);
    if (inside_out.empty()) return;
    const BoxTree closed_faces = tree_of_closed_faces();
    std::erase_if(inside_out, [&](Index c) { return lies_within(c, closed_faces) % 2 != 0; });
    for (Index f = 0; f < count(); ++f)
      turned_[f] ^= std::binary_search(inside_out.begin(), inside_out.end(), component_[f]);
  }

  BoxTree tree_of_closed_faces() const {
    std::vector<Index> closed;
    for (Index f = 0; f < count(); ++f)
      if (closed_[component_[f]]) closed.push_back(f);
    return {points_, faces_, std::move(closed)};
  }

  // How many other closed components enclose component c: those whose faces a ray upwards from one of its
  // faces leaves more often than it enters, or less often.
  int lies_within(Index c, const BoxTree& closed_faces) const {
    const Index first = first_face_[c];
    const Vec3 p = centroid(corners_of(faces_[first], points_));
    std::vector<std::pair<Index, int>> crossings;
    visit_above(p, closed_faces, points_, faces_, [&](Index f, int way) {
      if (component_[f] != c) crossings.push_back({component_[f], turned_[f] ? -way : way});
    });
    int enclosing = 0;
    for_unbalanced(crossings, [&](Index) { ++enclosing; });
    return enclosing;
  }

  Points points_;
  Faces faces_;
  const Halfedges& halfedges_;
  const CornerRows& rows_;
  Windings windings_;
  Flags fixed_;
  Array<Index> component_;  // per face; numbered by their first faces
  Array<std::uint8_t> turned_;
  std::vector<Index> first_face_;  // per component, and so the next two
  std::vector<std::uint8_t> may_turn_, closed_;
};

}  // namespace

std::vector<Index> find_misoriented(Points points, Faces faces, const Halfedges& halfedges, const CornerRows& rows,
                                    Flags fixed) {
  return Orienter(points, faces, halfedges, rows, fixed).find();
}

}  // namespace bldsimp
