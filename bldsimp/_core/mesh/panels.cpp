#include "mesh/panels.hpp"

#include <optional>

#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

// Nodes of so many faces, and of less than twice as many, get a panel.
constexpr Index kSizes[] = {4, 16, 64};
// A panel reaches beyond the faces of its node by this share of its size, so that a piece somewhat smaller than that
// always is inside of one.
constexpr double kBeyond = 0.5;
// Faces of a node that is as bent as this have no panel: length of the sum of area vectors beside the sum of lengths.
constexpr double kFlat = 0.8;
// Heights of a panel span at most this many limits.
constexpr double kThickest = 1.6;
constexpr double kRounding = 1e-9;

using FramePoint = Vec3;  // as the panel's own axes have it

class PanelFinder {
 public:
  PanelFinder(Points points, Faces faces, const BoxTree& tree, double limit)
      : points_(points), faces_(faces), tree_(tree), limit_(limit) {}

  std::optional<Panel> find(const BoxNode& node) {
    if (!frame(node)) return {};
    gather();
    if (panel_.high - panel_.low > kThickest * limit_ || !covered()) return {};
    return panel_;
  }

 private:
  const Face& face(Index i) const { return faces_[tree_.order()[i]]; }
  FramePoint place(Index p) const {
    const Vec3 way = points_[p] - panel_.middle;
    return {dot(way, panel_.x), dot(way, panel_.y), dot(way, panel_.z)};
  }

  // Puts a rectangle about the faces of a node; whether they are flat.
  bool frame(const BoxNode& node) {
    Vec3 sum{0, 0, 0};
    double area = 0;
    for (Index i = node.begin; i < node.end; ++i) {
      const auto& [a, b, c] = face(i);
      const Vec3 own = cross(points_[b] - points_[a], points_[c] - points_[a]);
      sum = sum + own;
      area += length(own);
    }
    const double size = length(sum);
    if (!(size > kFlat * area)) return false;
    panel_.z = (1 / size) * sum;
    panel_.middle = 0.5 * (node.low + node.high);
    panel_.x = square_to(panel_.z);
    panel_.y = cross(panel_.z, panel_.x);
    Box box;
    for (Index i = node.begin; i < node.end; ++i)
      for (const Index p : face(i)) box.add(place(p));
    const Vec3 middle = 0.5 * (box.low + box.high), half = 0.5 * (box.high - box.low);
    panel_.middle = panel_.middle + middle.x * panel_.x + middle.y * panel_.y + middle.z * panel_.z;
    panel_.low = -half.z, panel_.high = half.z;
    const double beyond = kBeyond * std::max(half.x, half.y);
    panel_.width = half.x + beyond, panel_.depth = half.y + beyond;
    return 2 * half.z <= kThickest * limit_;
  }

  // Edges of the faces that are at the rectangle and near its heights, and the heights of those.
  void gather() {
    const double low = panel_.low - limit_ / 2, high = panel_.high + limit_ / 2;
    const auto around = [&](Vec3 axis, double half) {
      return half * Vec3{std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)};
    };
    const Vec3 out = around(panel_.x, panel_.width) + around(panel_.y, panel_.depth) + around(panel_.z, high);
    edges_.clear();
    tree_.visit(Box{panel_.middle - out, panel_.middle + out}, [&](Index i) {
      Box box;
      for (const Index p : face(i)) box.add(place(p));
      if (!box.meets({{-panel_.width, -panel_.depth, low}, {panel_.width, panel_.depth, high}})) return true;
      panel_.low = std::min(panel_.low, box.low.z), panel_.high = std::max(panel_.high, box.high.z);
      const Face& f = face(i);
      for (int k = 0; k < 3; ++k) edges_.push_back({std::min(f[k], f[(k + 1) % 3]), std::max(f[k], f[(k + 1) % 3])});
      return true;
    });
  }

  // Faces cover each place as often as the next, evenly or oddly, unless one crosses an edge that an odd number of them
  // has. So it is enough that no such edge is at the rectangle, and that its middle is covered an odd number of times:
  // that is, that a ray from there crosses an odd number of such edges.
  bool covered() {
    std::sort(edges_.begin(), edges_.end());
    bool odd = false;
    for (std::size_t i = 0, next; i < edges_.size(); i = next) {
      for (next = i + 1; next < edges_.size() && edges_[next] == edges_[i];) ++next;
      if ((next - i) % 2 == 0) continue;
      const FramePoint p = place(edges_[i][0]), q = place(edges_[i][1]);
      if (meets(p, q)) return false;
      if ((p.y <= 0) == (q.y <= 0)) continue;
      odd ^= p.x + (0 - p.y) / (q.y - p.y) * (q.x - p.x) > 0;
    }
    return odd;
  }

  // Whether an edge is at the rectangle.
  bool meets(const FramePoint& p, const FramePoint& q) const {
    const double w = (1 + kRounding) * panel_.width, d = (1 + kRounding) * panel_.depth;
    if (std::min(p.x, q.x) > w || std::max(p.x, q.x) < -w || std::min(p.y, q.y) > d || std::max(p.y, q.y) < -d)
      return false;
    // All corners on one side of its line.
    const double nx = q.y - p.y, ny = p.x - q.x, at = nx * p.x + ny * p.y;
    return std::abs(at) <= std::abs(nx) * w + std::abs(ny) * d;
  }

  Points points_;
  Faces faces_;
  const BoxTree& tree_;
  double limit_;
  Panel panel_;
  std::vector<Edge> edges_;
};

}  // namespace

bool Panel::holds(Points corners, double limit) const {
  return std::all_of(corners.begin(), corners.end(), [&](const Vec3& p) {
    const Vec3 way = p - middle;
    const double height = dot(way, z);
    return std::abs(dot(way, x)) <= width && std::abs(dot(way, y)) <= depth && height - low <= limit &&
           high - height <= limit;
  });
}

Panels::Panels(Points points, Faces faces, const BoxTree& tree, double limit) {
  const auto& nodes = tree.nodes();
  std::vector<Index> wanted;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Index count = nodes[n].end - nodes[n].begin;
    if (std::any_of(std::begin(kSizes), std::end(kSizes),
                    [&](Index size) { return size <= count && count < 2 * size; }))
      wanted.push_back(static_cast<Index>(n));
  }
  std::vector<std::optional<Panel>> found(wanted.size());
  parallel_for(
      wanted.size(),
      [&](std::size_t begin, std::size_t end) {
        PanelFinder finding(points, faces, tree, limit);
        for (std::size_t i = begin; i < end; ++i) found[i] = finding.find(nodes[wanted[i]]);
      },
      64);
  place_.assign(nodes.size(), -1);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!found[i]) continue;
    place_[wanted[i]] = static_cast<Index>(panels_.size());
    panels_.push_back(*found[i]);
  }
}

}  // namespace bldsimp
