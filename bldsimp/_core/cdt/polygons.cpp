#include "cdt/polygons.hpp"

#include "cdt/cdt.hpp"
#include "mesh/vec3.hpp"

namespace bldsimp {
namespace {

// How an edge is used: forward minus backward, by its ends in rising order.
struct EdgeBalance {
  Index a, b;
  int uses;
};

// Twice the area vector (Newell), about the first point.
Vec3 newell_vector(Points outline) {
  Vec3 sum{0, 0, 0};
  for (std::size_t i = 0; i < outline.size(); ++i)
    sum = sum + cross(outline[i] - outline[0], outline[(i + 1) % outline.size()] - outline[0]);
  return sum;
}

// Triangulates one outline after the other in a workspace that is reused.
class PolygonCutter {
 public:
  // Faces in rows of `outline`.
  const std::vector<Face>& cut(Points outline) {
    faces_.clear();
    read(outline);
    if (!cut_by_core() || !keeps_outline()) cut_by_ears();
    return faces_;
  }

 private:
  // Drops the axis along which the outline is thinnest, so that coordinates stay exact, and lifts each
  // point by its squared length in space, so that Delaunay is meant in the polygon's own plane.
  void read(Points outline) {
    const Vec3 normal = newell_vector(outline);
    const double x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
    flat_.clear();
    lift_.clear();
    segment_.clear();
    const auto size = static_cast<Index>(outline.size());
    for (Index i = 0; i < size; ++i) {
      const Vec3& p = outline[i];
      Point2 flat{p.x, p.y};
      bool turned = normal.z < 0;
      if (x >= y && x > z) {
        flat = {p.y, p.z};
        turned = normal.x < 0;
      } else if (y > z) {
        flat = {p.z, p.x};
        turned = normal.y < 0;
      }
      if (turned) std::swap(flat.x, flat.y);
      flat_.push_back(flat);
      const Vec3 arm = p - outline[0];
      lift_.push_back(dot(arm, arm));
      segment_.push_back({i, (i + 1) % size});
    }
    name_positions(outline);
  }

  void name_positions(Points outline) {
    const auto key = [&](Index i) { return std::array{outline[i].x, outline[i].y, outline[i].z}; };
    position_.resize(outline.size());
    order_ = list_indices(outline.size());
    std::sort(order_.begin(), order_.end(),
              [&](Index i, Index j) { return key(i) != key(j) ? key(i) < key(j) : i < j; });
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const bool same = i > 0 && key(order_[i]) == key(order_[i - 1]);
      position_[order_[i]] = same ? position_[order_[i - 1]] : order_[i];
    }
  }

  bool cut_by_core() {
    const bool finite = std::all_of(lift_.begin(), lift_.end(), [](double l) { return std::isfinite(l); });
    const TriangulateOptions options{.lift = finite ? lift_.data() : nullptr};
    if (triangulator_.run(flat_, segment_, options) != Status::done) return false;
    faces_ = triangulator_.triangles();
    close_split_edges();
    return true;
  }

  // Faces of no area between an edge of the outline and the pieces into which corners on it cut it.
  void close_split_edges() {
    const auto& pieces = triangulator_.pieces();
    for (std::size_t first = 0, last; first < pieces.size(); first = last) {
      last = first + 1;
      while (last < pieces.size() && pieces[last].segment == pieces[first].segment) ++last;
      for (std::size_t i = last - 1; i > first; --i) faces_.push_back({pieces[first].a, pieces[i].b, pieces[i].a});
    }
  }

  // Whether the faces use every edge as the outline does, but for edges inside, used both ways.
  bool keeps_outline() {
    balance_.clear();
    const auto count = [&](Index from, Index to, int use) {
      const Index a = position_[from], b = position_[to];
      if (a != b) balance_.push_back({std::min(a, b), std::max(a, b), a < b ? use : -use});
    };
    for (const auto& [from, to] : segment_) count(from, to, 1);
    for (const Face& face : faces_)
      for (std::size_t i = 0; i < 3; ++i) count(face[i], face[(i + 1) % 3], -1);
    std::sort(balance_.begin(), balance_.end(),
              [](const EdgeBalance& p, const EdgeBalance& q) { return p.a != q.a ? p.a < q.a : p.b < q.b; });
    for (std::size_t first = 0, last; first < balance_.size(); first = last) {
      int uses = 0;
      for (last = first;
           last < balance_.size() && balance_[last].a == balance_[first].a && balance_[last].b == balance_[first].b;
           ++last)
        uses += balance_[last].uses;
      if (uses != 0) return false;
    }
    return true;
  }

  // The last way: any cut of the cycle of corners uses its edges rightly. Ears where there are some.
  void cut_by_ears() {
    faces_.clear();
    left_.clear();
    for (Index i = 0; i < static_cast<Index>(flat_.size()); ++i)
      if (left_.empty() || position_[i] != position_[left_.back()]) left_.push_back(i);
    while (left_.size() > 1 && position_[left_.front()] == position_[left_.back()]) left_.pop_back();
    constexpr std::size_t patience = 2000;  // corners; beyond, a fan instead of a search in O(n^3)
    while (left_.size() >= 3) {
      std::size_t ear = 1;
      if (left_.size() <= patience)
        for (std::size_t i = 1; i <= left_.size(); ++i)
          if (is_ear(i)) {
            ear = i;
            break;
          }
      const std::size_t size = left_.size();
      const Face face{left_[(ear + size - 1) % size], left_[ear % size], left_[(ear + 1) % size]};
      if (position_[face[0]] != position_[face[2]]) faces_.push_back(face);
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(ear % size));
    }
  }

  // Whether corner i turns left and no other corner lies in its triangle.
  bool is_ear(std::size_t i) const {
    const std::size_t size = left_.size();
    const Point2 &a = at(i + size - 1), &b = at(i), &c = at(i + 1);
    if (orient2d(a, b, c) <= 0) return false;
    for (std::size_t k = i + 2; k < i + size - 1; ++k) {
      const Point2& p = at(k);
      if (p == a || p == b || p == c) continue;
      if (orient2d(a, b, p) >= 0 && orient2d(b, c, p) >= 0 && orient2d(c, a, p) >= 0) return false;
    }
    return true;
  }

  const Point2& at(std::size_t i) const { return flat_[left_[i % left_.size()]]; }

  Triangulator triangulator_;
  std::vector<Point2> flat_;
  std::vector<double> lift_;
  std::vector<Triangulator::Segment> segment_;
  std::vector<Index> position_;  // the lowest row of the same point in space
  std::vector<Index> order_, left_;
  std::vector<EdgeBalance> balance_;
  std::vector<Face> faces_;
};

}  // namespace

PolygonFaces triangulate_polygons(Points points, std::span<const std::int64_t> offsets, Indices corners) {
  PolygonFaces result;
  PolygonCutter cutter;
  std::vector<Vec3> outline;
  for (std::size_t polygon = 0; polygon + 1 < offsets.size(); ++polygon) {
    const auto begin = static_cast<std::size_t>(offsets[polygon]);
    const auto ring = corners.subspan(begin, static_cast<std::size_t>(offsets[polygon + 1]) - begin);
    if (ring.size() < 3) continue;
    if (ring.size() == 3) {
      result.faces.push_back({ring[0], ring[1], ring[2]});
    } else {
      outline.clear();
      for (const Index corner : ring) outline.push_back(points[corner]);
      for (const Face& face : cutter.cut(outline))
        result.faces.push_back({ring[face[0]], ring[face[1]], ring[face[2]]});
    }
    result.polygon_of_face.resize(result.faces.size(), static_cast<Index>(polygon));
  }
  return result;
}

}  // namespace bldsimp
