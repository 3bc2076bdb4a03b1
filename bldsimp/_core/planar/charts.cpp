#include "planar/charts.hpp"

#include "mesh/eigen.hpp"
#include "mesh/index_sets.hpp"
#include "mesh/parallel.hpp"

namespace bldsimp {
namespace {

// A direction in which the value changes over the chart by a smaller share of the limit than this tells nothing.
constexpr double least_told = 0.05;
// Below this share of the largest, an eigenvalue is rounding.
constexpr double flat = 1e-13;
// So many times faster than in the plane that the chart spreads in, a value cannot change across it: such a change
// is read off heights that are noise, and would tear the picture where points move along it.
constexpr double steepest = 2;
// A region of fewer faces is fitted anew with each face that may join: the planes of single faces are too noisy.
constexpr std::size_t small_region = 16;

// Area-weighted moments of positions and values about one corner, and the affine map that fits them best.
class AffineFit {
 public:
  explicit AffineFit(std::size_t columns) : columns_(columns), gradient_(columns), offset_(columns) {
    clear({}, nullptr);
  }

  void clear(Vec3 origin, const double* values) {
    origin_ = origin;
    weight_ = 0;
    first_ = {0, 0, 0};
    second_.fill(0);
    base_.assign(columns_, 0);
    if (values) base_.assign(values, values + columns_);
    value_.assign(columns_, 0);
    mixed_.assign(columns_, Vec3{0, 0, 0});
  }

  void add(Vec3 p, const double* values, double weight) {
    p = p - origin_;
    weight_ += weight;
    first_ = first_ + weight * p;
    second_[0] += weight * p.x * p.x;
    second_[1] += weight * p.x * p.y;
    second_[2] += weight * p.x * p.z;
    second_[3] += weight * p.y * p.y;
    second_[4] += weight * p.y * p.z;
    second_[5] += weight * p.z * p.z;
    for (std::size_t c = 0; c < columns_; ++c) {
      const double u = values[c] - base_[c];
      value_[c] += weight * u;
      mixed_[c] = mixed_[c] + (weight * u) * p;
    }
  }

  // `told` is, for each column, the least change of the value over the chart that counts.
  void fit(std::span<const double> told) {
    if (!(weight_ > 0)) {
      std::fill(gradient_.begin(), gradient_.end(), Vec3{0, 0, 0});
      offset_ = base_;
      return;
    }
    const double w = 1 / weight_;
    const Vec3 m = w * first_;
    const EigenSystem found =
        decompose({w * second_[0] - m.x * m.x, w * second_[1] - m.x * m.y, w * second_[2] - m.x * m.z,
                   w * second_[3] - m.y * m.y, w * second_[4] - m.y * m.z, w * second_[5] - m.z * m.z});
    std::array<int, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int a, int b) { return found.values[a] > found.values[b]; });
    const double largest = found.values[order[0]];
    for (std::size_t c = 0; c < columns_; ++c) {
      const double mean = w * value_[c];
      const Vec3 covariance = w * mixed_[c] - mean * m;
      gradient_[c] = {0, 0, 0};
      for (const int k : order) {
        const double spread = found.values[k];
        if (!(spread > flat * largest)) continue;
        const double along = dot(covariance, found.vectors[k]);
        if (std::abs(along) <= told[c] * std::sqrt(spread)) continue;
        if (k == order[2] && std::abs(along / spread) > steepest * length(gradient_[c])) continue;
        gradient_[c] = gradient_[c] + (along / spread) * found.vectors[k];
      }
      offset_[c] = base_[c] + mean - dot(gradient_[c], m);
    }
  }

  double at(Vec3 p, std::size_t column) const { return offset_[column] + dot(gradient_[column], p - origin_); }
  Vec3 gradient(std::size_t column) const { return gradient_[column]; }

 private:
  std::size_t columns_;
  Vec3 origin_;
  double weight_;
  Vec3 first_;
  std::array<double, 6> second_;
  std::vector<double> base_, value_;
  std::vector<Vec3> mixed_, gradient_;
  std::vector<double> offset_;
};

constexpr Index none = -1, waiting = -2;

// What the finders of all threads read; and the charts of faces, of which each writes those of its own groups.
struct ChartState {
  Points points;
  Faces faces;
  Indices twin, start, order, part;
  const AttributeColumns& columns;
  Array<Face> rows;  // of the corners
  Array<Index> group, chart;
};

class ChartFinder {
 public:
  explicit ChartFinder(ChartState& all)
      : all_(all), points_(all.points), faces_(all.faces), attributes_(all.columns),
        columns_(attributes_.limits.size()), fit_map_(columns_), told_(columns_), low_(columns_), high_(columns_) {}

  // Charts of some groups, numbered among themselves.
  Charts find(std::size_t first, std::size_t last) {
    for (std::size_t g = first; g < last; ++g) {
      const Indices members = all_.order.subspan(all_.start[g], all_.start[g + 1] - all_.start[g]);
      if (members.empty()) continue;
      fit(members);
      if (measure(members))
        take(members);
      else
        cut_up(members);
    }
    return std::move(charts_);
  }

 private:
  Vec3 corner(Index f, int i) const { return points_[faces_[f][i]]; }
  const double* values(Index f, int i) const { return &attributes_.values[columns_ * all_.rows[f][i]]; }
  double steps(Index f, std::size_t column) const { return attributes_.steps[columns_ * all_.part[f] + column]; }
  double area(Index f) const { return length(cross(corner(f, 1) - corner(f, 0), corner(f, 2) - corner(f, 0))) / 2; }

  void add(Index f) {
    const double weight = area(f) / 3;
    for (int i = 0; i < 3; ++i) fit_map_.add(corner(f, i), values(f, i), weight);
  }

  void settle(Index f) {
    for (std::size_t c = 0; c < columns_; ++c) told_[c] = least_told * attributes_.limits[c] / steps(f, c);
    fit_map_.fit(told_);
  }

  void fit(Indices members) {
    fit_map_.clear(corner(members[0], 0), values(members[0], 0));
    for (const Index f : members) add(f);
    settle(members[0]);
  }

  // Whether what the corners of a face carry is on the map.
  bool fits(Index f) const {
    for (int i = 0; i < 3; ++i)
      for (std::size_t c = 0; c < columns_; ++c) {
        const double off = values(f, i)[c] - fit_map_.at(corner(f, i), c);
        if (!(2 * std::abs(off) * steps(f, c) <= attributes_.limits[c])) return false;
      }
    return true;
  }

  // Charts of a group that is none as a whole.
  void cut_up(Indices members) {
    std::vector<std::pair<double, Index>> seeds;
    seeds.reserve(members.size());
    for (const Index f : members) seeds.push_back({-area(f), f});
    std::sort(seeds.begin(), seeds.end());
    for (const auto& [size, seed] : seeds)
      if (all_.chart[seed] == none) grow(seed);
  }

  // The map is fitted anew whenever the region has doubled; what it then leaves out waits for another seed.
  void grow(Index seed) {
    region_.assign(1, seed);
    all_.chart[seed] = waiting;
    fit(region_);
    start();
    sweep();
    for (std::size_t before = 0; before != region_.size();) {
      before = region_.size();
      fit(region_);
      sweep();
    }
    if (!keep_fitting(seed)) {
      for (const Index f : region_) all_.chart[f] = none;
      region_.assign(1, seed);
      fit(region_);
    }
    measure(region_);
    take(region_);
  }

  // Adds neighbors for as long as one map fits all.
  void start() {
    for (std::size_t front = 0; front < region_.size(); ++front)
      for (int i = 0; i < 3 && region_.size() < small_region; ++i) {
        const Index t = all_.twin[3 * region_[front] + i];
        if (t < 0 || !may_join(t / 3)) continue;
        region_.push_back(t / 3);
        fit(region_);
        if (std::all_of(region_.begin(), region_.end(), [&](Index f) { return fits(f); }))
          all_.chart[t / 3] = waiting;
        else
          region_.pop_back();
      }
    fit(region_);
  }

  // Faces of other groups may be another thread's.
  bool may_join(Index f) const { return all_.group[f] == all_.group[region_[0]] && all_.chart[f] == none; }

  // Adds what fits, from neighbor to neighbor.
  void sweep() {
    std::size_t next_fit = 2 * region_.size();
    for (std::size_t front = 0; front < region_.size(); ++front)
      for (int i = 0; i < 3; ++i) {
        const Index t = all_.twin[3 * region_[front] + i];
        if (t < 0) continue;
        const Index f = t / 3;
        if (!may_join(f) || !fits(f)) continue;
        all_.chart[f] = waiting;
        region_.push_back(f);
        add(f);
        if (region_.size() >= next_fit) {
          settle(f);
          next_fit *= 2;
        }
      }
  }

  // Leaves out what the last map does not fit; false where that is the seed.
  bool keep_fitting(Index seed) {
    if (!fits(seed)) return false;
    const auto end = std::remove_if(region_.begin(), region_.end(), [&](Index f) {
      if (fits(f)) return false;
      all_.chart[f] = none;
      return true;
    });
    region_.erase(end, region_.end());
    return true;
  }

  // How far faces are off the map at most; whether it fits all of them.
  bool measure(Indices members) {
    std::fill(low_.begin(), low_.end(), 0.0);
    std::fill(high_.begin(), high_.end(), 0.0);
    bool all_fit = true;
    for (const Index f : members)
      for (int i = 0; i < 3; ++i)
        for (std::size_t c = 0; c < columns_; ++c) {
          const double off = (values(f, i)[c] - fit_map_.at(corner(f, i), c)) * steps(f, c);
          low_[c] = std::min(low_[c], off);
          high_[c] = std::max(high_[c], off);
          all_fit &= 2 * std::abs(off) <= attributes_.limits[c];
        }
    return all_fit;
  }

  // Makes faces that were measured a chart, with the map that was fitted last.
  void take(Indices members) {
    const Index chart = static_cast<Index>(charts_.spans.size() / columns_);
    // One face has a map of its own, but for a needle, of which no map can be told.
    if (members.size() == 1) low_ = high_;
    for (const Index f : members) all_.chart[f] = chart;
    for (std::size_t c = 0; c < columns_; ++c) {
      charts_.spans.push_back(high_[c] - low_[c]);
      const Vec3 gradient = fit_map_.gradient(c);
      charts_.maps.insert(charts_.maps.end(), {gradient.x, gradient.y, gradient.z, fit_map_.at({0, 0, 0}, c)});
    }
  }

  ChartState& all_;
  Points points_;
  Faces faces_;
  const AttributeColumns& attributes_;
  std::size_t columns_;
  AffineFit fit_map_;
  std::vector<double> told_, low_, high_;
  Charts charts_;
  std::vector<Index> region_;
};

}  // namespace

Charts find_charts(Points points, Faces faces, const Halfedges& halfedges, Indices start, Indices order,
                   const CornerRows& rows, Indices part_of_face, const AttributeColumns& columns) {
  ChartState all{points, faces, halfedges.twin, start, order, part_of_face, columns, {}, {}, {}};
  all.rows.resize(faces.size());
  all.group.resize(faces.size());
  all.chart.resize(faces.size());
  parallel_each(faces.size(), [&](Index f) {
    for (int i = 0; i < 3; ++i) all.rows[f][i] = rows.at(f, faces[f][i]);
    all.chart[f] = none;
  });
  const std::size_t groups = start.empty() ? 0 : start.size() - 1;
  for (std::size_t g = 0; g < groups; ++g)
    for (Index i = start[g]; i < start[g + 1]; ++i) all.group[order[i]] = static_cast<Index>(g);
  // Every thread takes the groups that start within its range of faces.
  struct Own {
    std::size_t first, last;
    Charts charts;
  };
  const auto group_from = [&](std::size_t face) {
    const auto place = std::lower_bound(start.begin(), start.begin() + groups, static_cast<Index>(face));
    return static_cast<std::size_t>(place - start.begin());
  };
  Charts charts;
  parallel_collect(
      order.size(),
      [&](std::size_t begin, std::size_t end) {
        const std::size_t first = group_from(begin), last = end == order.size() ? groups : group_from(end);
        return Own{first, last, ChartFinder(all).find(first, last)};
      },
      [&](const Own& own) {
        const auto before = static_cast<Index>(charts.spans.size() / columns.limits.size());
        append(charts.spans, own.charts.spans);
        append(charts.maps, own.charts.maps);
        if (before > 0 && own.first < own.last)
          for (Index i = start[own.first]; i < start[own.last]; ++i) all.chart[order[i]] += before;
      });
  charts.chart_of_face = std::move(all.chart);
  return charts;
}

Array<Index> find_smooth(Points points, Faces faces, const Halfedges& halfedges, const CornerRows& rows, Points normals,
                         double cosine, double needle) {
  const auto is_needle = [&](Index f) {
    const Vec3 a = points[faces[f][0]], b = points[faces[f][1]], c = points[faces[f][2]];
    return length(cross(b - a, c - a)) <= needle * std::max({length(b - a), length(c - b), length(a - c)});
  };
  const auto smooth = [&](Index f, Index g, Index point) {
    const Vec3 a = normals[rows.at(f, point)], b = normals[rows.at(g, point)];
    return dot(a, b) >= cosine * length(a) * length(b);
  };
  return join_across(halfedges.twin, [&](Index h, Index t) {
    const Index f = h / 3, g = t / 3;
    return (smooth(f, g, faces[f][h % 3]) && smooth(f, g, faces[g][t % 3])) || is_needle(f) || is_needle(g);
  });
}

}  // namespace bldsimp
