#include "details/facet_graph.hpp"

#include <tuple>

namespace bldsimp {

FacetGraph::FacetGraph(Points points, Faces faces, Indices label, double flat)
    : points_(points.begin(), points.end()), faces_(faces.begin(), faces.end()), flat_(flat),
      halfedges_(pair_halfedges(points_, faces_, {}, flat)),
      facets_(find_facets(points_, faces_, halfedges_, label, {0, 0, 0}, {2 * flat, flat, flat})),
      members_(facets_.planes.size(), faces_.size(), [&](Index f) { return facets_.facet_of_face[f]; }),
      star_(points_.size(), 3 * faces_.size(), [&](Index h) { return origin(faces_, h); }),
      shapes_(facets_.planes.size()) {
  for (Index& h : star_.members) h /= 3;
  for (std::size_t f = 0; f < faces_.size(); ++f) shapes_[facets_.facet_of_face[f]].label = label[f];
  measure_shapes();
  find_neighbors();
}

void FacetGraph::measure_shapes() {
  for (Index k = 0; k < facet_count(); ++k) {
    FacetShape& own = shapes_[k];
    const Plane& plane = facets_.planes[k];
    own.normal = plane.normal;
    own.offset = (plane.low + plane.high) / 2;
    Box& box = own.box;
    for (const Index f : members_[k]) {
      own.area += length(area_vector(corners_of(faces_[f], points_))) / 2;
      for (const Index p : faces_[f]) box.add(points_[p]);
    }
    own.center = 0.5 * (box.low + box.high);
    own.radius = length(box.high - box.low) / 2;
  }
}

Fold FacetGraph::fold_at(Index halfedge, Index twin) const {
  const double height = height_over(facet_of(halfedge / 3), points_[apex(faces_, twin)]);
  return height > flat_ ? Fold::concave : height < -flat_ ? Fold::convex : Fold::mixed;
}

void FacetGraph::find_neighbors() {
  std::vector<std::tuple<Index, Index, Fold>> found;
  for (Index h = 0; h < std::ssize(halfedges_.twin); ++h) {
    const Index t = halfedges_.twin[h];
    if (t < 0 || facet_of(h / 3) == facet_of(t / 3)) continue;
    found.push_back({facet_of(h / 3), facet_of(t / 3), fold_at(h, t)});
  }
  std::sort(found.begin(), found.end());
  neighbor_start_.assign(shapes_.size() + 1, 0);
  const auto same = [](const auto& a, const auto& b) {
    return std::get<0>(a) == std::get<0>(b) && std::get<1>(a) == std::get<1>(b);
  };
  for_runs(found, same, [&](auto edges) {
    const auto [own, other, first] = edges.front();
    const bool one = first == std::get<2>(edges.back());
    neighbors_.push_back({other, one ? first : Fold::mixed});
    ++neighbor_start_[own + 1];
  });
  std::partial_sum(neighbor_start_.begin(), neighbor_start_.end(), neighbor_start_.begin());
}

bool FacetGraph::share_plane(Index f, Index g) const {
  if (f == g) return true;
  const FacetShape &a = shapes_[f], &b = shapes_[g];
  if (dot(a.normal, b.normal) <= 0) return false;
  // The planes part least at the smaller facet, and the larger one's plane is the surer one.
  const bool first = a.radius <= b.radius;
  const FacetShape &small = first ? a : b, &large = first ? b : a;
  return std::abs(dot(large.normal, small.center) - large.offset) +
             small.radius * length(small.normal - large.normal) <=
         4 * flat_;
}

double FacetGraph::width_of(Index facet) const {
  const FacetShape& own = shapes_[facet];
  const Vec3 u = square_to(own.normal), v = cross(own.normal, u);
  const auto flat = [&](Index p) {
    const Vec3 d = points_[p] - own.center;
    return Point2{dot(d, u), dot(d, v)};
  };
  // Moments of the area about its middle; twelve times.
  double area = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (const Index f : members_[facet]) {
    const double size = length(area_vector(corners_of(faces_[f], points_)));
    const Point2 a = flat(faces_[f][0]), b = flat(faces_[f][1]), c = flat(faces_[f][2]);
    const double sx = a.x + b.x + c.x, sy = a.y + b.y + c.y;
    area += size, x += size / 3 * sx, y += size / 3 * sy;
    xx += size * (a.x * a.x + b.x * b.x + c.x * c.x + sx * sx);
    xy += size * (a.x * a.y + b.x * b.y + c.x * c.y + sx * sy);
    yy += size * (a.y * a.y + b.y * b.y + c.y * c.y + sy * sy);
  }
  if (area > 0) xx -= 12 * x * x / area, xy -= 12 * x * y / area, yy -= 12 * y * y / area;
  // The axis of the least spread; twice its angle is that of (xx - yy, 2 xy), turned by half a turn.
  const double size = std::hypot(xx - yy, 2 * xy), cosine = size > 0 ? (xx - yy) / size : 1;
  const double s = std::sqrt(std::max(0.0, (1 + cosine) / 2));
  const double t = std::copysign(std::sqrt(std::max(0.0, (1 - cosine) / 2)), xy);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Index f : members_[facet])
    for (const Index p : faces_[f]) {
      const Point2 at = flat(p);
      low = std::min(low, s * at.y - t * at.x), high = std::max(high, s * at.y - t * at.x);
    }
  return high - low;
}

std::vector<Loop> FacetGraph::find_loops(Indices facets) const {
  const auto goes = [&](Index face) { return std::binary_search(facets.begin(), facets.end(), facet_of(face)); };
  const auto is_border = [&](Index h) { return halfedges_.twin[h] < 0 || !goes(halfedges_.twin[h] / 3); };
  std::vector<Index> border;
  for (const Index k : facets)
    for (const Index f : members_[k])
      for (Index h = 3 * f; h < 3 * f + 3; ++h)
        if (is_border(h)) border.push_back(h);
  std::sort(border.begin(), border.end());
  std::vector<bool> seen(border.size(), false);
  std::vector<Loop> loops;
  for (std::size_t i = 0; i < border.size(); ++i) {
    if (seen[i]) continue;
    Loop loop;
    for (Index h = border[i];;) {
      const auto at = static_cast<std::size_t>(std::lower_bound(border.begin(), border.end(), h) - border.begin());
      if (seen[at]) break;
      seen[at] = true;
      const Index t = halfedges_.twin[h];
      loop.push_back({origin(faces_, h), target(faces_, h), t < 0 ? -1 : t / 3});
      h = next_halfedge(h);
      while (!is_border(h)) h = next_halfedge(halfedges_.twin[h]);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

std::vector<Loop> FacetGraph::find_open_loops() const {
  const auto& twin = halfedges_.twin;
  std::vector<bool> seen(twin.size(), false);
  std::vector<Loop> loops;
  for (Index first = 0; first < std::ssize(twin); ++first) {
    if (twin[first] >= 0 || seen[first]) continue;
    Loop loop;
    for (Index h = first; !seen[h];) {
      seen[h] = true;
      loop.push_back({target(faces_, h), origin(faces_, h), h / 3});
      h = previous_halfedge(h);
      while (twin[h] >= 0) h = previous_halfedge(twin[h]);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

double FacetGraph::twice_area(const Loop& loop, Vec3 normal) const {
  const Vec3 o = points_[loop[0].from];
  Vec3 sum{0, 0, 0};
  for (const LoopEdge& e : loop) sum = sum + cross(points_[e.from] - o, points_[e.to] - o);
  return dot(sum, normal);
}

}  // namespace bldsimp
