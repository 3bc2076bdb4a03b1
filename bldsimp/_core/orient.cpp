#include "orient.hpp"

#include <numbers>

#include "edges.hpp"

namespace bldsimp {
namespace {

struct Component {
  std::vector<Index> faces;
  bool closed = true;
  bool may_turn = true;
};

class Orienter {
 public:
  Orienter(std::span<const Vec3> points, std::span<const Face> faces, std::span<const Face> rows,
           std::span<const std::uint8_t> fixed)
      : points_(points), faces_(faces), fixed_(fixed), mate_(3 * faces.size(), -1), turned_(faces.size(), 0),
        component_(faces.size(), -1) {
    for_each_edge(faces, static_cast<Index>(points.size()), [&](std::span<const Index> edge) {
      if (edge.size() == 2)
        mate(edge[0], edge[1]);
      else
        mate_by_rows(edge, rows);
    });
  }

  std::vector<Index> find() {
    for (Index f = 0; f < static_cast<Index>(faces_.size()); ++f)
      if (component_[f] < 0) spread_from(f);
    find_open_components();
    for (Index c = 0; c < static_cast<Index>(components_.size()); ++c)
      if (is_inside_out(c))
        for (const Index f : components_[c].faces) turned_[f] ^= 1;
    std::vector<Index> result;
    for (Index f = 0; f < static_cast<Index>(faces_.size()); ++f)
      if (turned_[f]) result.push_back(f);
    return result;
  }

 private:
  Vec3 corner(Index f, int i) const { return points_[faces_[f][i]]; }
  Vec3 area_vector(Index f) const { return cross(corner(f, 1) - corner(f, 0), corner(f, 2) - corner(f, 0)); }
  bool runs_forward(Index h) const { return (origin(faces_, h) < target(faces_, h)) != (turned_[h / 3] != 0); }

  void mate(Index g, Index h) {
    mate_[g] = h;
    mate_[h] = g;
  }

  void mate_by_rows(std::span<const Index> edge, std::span<const Face> rows) {
    const auto key = [&](Index h) { return std::minmax({origin(rows, h), target(rows, h)}); };
    for (const Index h : edge) {
      Index found = -1, matches = 0;
      for (const Index g : edge) {
        if (g == h || key(g) != key(h)) continue;
        found = g;
        ++matches;
      }
      if (matches == 1) mate(h, found);
    }
  }

  void spread_from(Index first) {
    const Index c = static_cast<Index>(components_.size());
    Component& component = components_.emplace_back();
    component.faces.push_back(first);
    component_[first] = c;
    bool consistent = true;
    for (std::size_t i = 0; i < component.faces.size(); ++i) {
      const Index f = component.faces[i];
      component.may_turn &= !fixed_[f];
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        const Index g = mate_[h];
        if (g < 0) continue;
        if (component_[g / 3] < 0) {
          component_[g / 3] = c;
          turned_[g / 3] = runs_forward(h) == runs_forward(g);
          component.faces.push_back(g / 3);
        } else if (runs_forward(h) == runs_forward(g)) {
          consistent = false;
        }
      }
    }
    component.may_turn &= consistent;
    double balance = 0;
    for (const Index f : component.faces) balance += (turned_[f] ? -1 : 1) * length(area_vector(f));
    const std::uint8_t all = balance < 0 && component.may_turn;
    for (const Index f : component.faces) turned_[f] = component.may_turn ? turned_[f] ^ all : 0;
  }

  // A component is closed if on each of its edges as many of its halfedges run one way as the other.
  void find_open_components() {
    std::vector<std::pair<Index, int>> balance;
    for_each_edge(faces_, static_cast<Index>(points_.size()), [&](std::span<const Index> edge) {
      balance.clear();
      for (const Index h : edge) balance.push_back({component_[h / 3], runs_forward(h) ? 1 : -1});
      std::sort(balance.begin(), balance.end());
      for (std::size_t i = 0; i < balance.size();) {
        const Index c = balance[i].first;
        int sum = 0;
        for (; i < balance.size() && balance[i].first == c; ++i) sum += balance[i].second;
        if (sum != 0) components_[c].closed = false;
      }
    });
  }

  bool is_inside_out(Index c) const {
    const Component& component = components_[c];
    if (!component.closed || !component.may_turn) return false;
    const Vec3 origin = corner(component.faces[0], 0);
    double volume = 0, magnitude = 0;
    for (const Index f : component.faces) {
      const double part = dot(corner(f, 0) - origin, area_vector(f));
      volume += turned_[f] ? -part : part;
      magnitude += std::abs(part);
    }
    if (volume >= -1e-9 * magnitude) return false;
    int depth = 0;
    const Vec3 p = (1.0 / 3) * (corner(component.faces[0], 0) + corner(component.faces[0], 1) + corner(component.faces[0], 2));
    for (Index other = 0; other < static_cast<Index>(components_.size()); ++other)
      if (other != c && components_[other].closed && contains(components_[other], p)) ++depth;
    return depth % 2 == 0;
  }

  // By the solid angle under which the component is seen (van Oosterom and Strackee, 1983).
  bool contains(const Component& component, Vec3 p) const {
    double angle = 0;
    for (const Index f : component.faces) {
      const Vec3 a = corner(f, 0) - p, b = corner(f, 1) - p, c = corner(f, 2) - p;
      const double la = length(a), lb = length(b), lc = length(c);
      const double above = dot(a, cross(b, c));
      const double below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
      angle += (turned_[f] ? -2 : 2) * std::atan2(above, below);
    }
    return std::abs(angle) > 2 * std::numbers::pi;
  }

  std::span<const Vec3> points_;
  std::span<const Face> faces_;
  std::span<const std::uint8_t> fixed_;
  std::vector<Index> mate_;
  std::vector<std::uint8_t> turned_;
  std::vector<Index> component_;
  std::vector<Component> components_;
};

}  // namespace

std::vector<Index> find_turned(std::span<const Vec3> points, std::span<const Face> faces,
                               std::span<const Face> rows, std::span<const std::uint8_t> fixed) {
  return Orienter(points, faces, rows, fixed).find();
}

}  // namespace bldsimp
