#include "charts.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "eigen.hpp"
#include "face_sets.hpp"

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
class Map {
 public:
  explicit Map(std::size_t columns) : columns_(columns), gradient_(columns), offset_(columns) { clear({}, nullptr); }

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
    const Eigen found = eigen({w * second_[0] - m.x * m.x, w * second_[1] - m.x * m.y, w * second_[2] - m.x * m.z,
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

// What corners of faces carry, and the map that was fitted to some of them last; each thread has its own.
class Fitter {
 public:
  Fitter(std::span<const Vec3> points, std::span<const Face> faces, const Rows& rows, std::span<const Index> part,
         const Carried& carried)
      : points_(points), faces_(faces), rows_(rows), part_(part), carried_(carried), columns_(carried.limits.size()),
        map_(columns_), told_(columns_), low_(columns_), high_(columns_) {}

  double area(Index f) const { return length(cross(corner(f, 1) - corner(f, 0), corner(f, 2) - corner(f, 0))) / 2; }

  void fit(std::span<const Index> members) {
    map_.clear(corner(members[0], 0), values(members[0], 0));
    for (const Index f : members) add(f);
    settle(members[0]);
  }

  void add(Index f) {
    const double weight = area(f) / 3;
    for (int i = 0; i < 3; ++i) map_.add(corner(f, i), values(f, i), weight);
  }

  // Fits the map to what was added.
  void settle(Index f) {
    for (std::size_t c = 0; c < columns_; ++c) told_[c] = least_told * carried_.limits[c] / steps(f, c);
    map_.fit(told_);
  }

  // Whether what the corners of a face carry is on the map.
  bool fits(Index f) const {
    for (int i = 0; i < 3; ++i) {
      const Vec3 p = corner(f, i);
      const double* carried = values(f, i);
      for (std::size_t c = 0; c < columns_; ++c)
        if (!(2 * std::abs(carried[c] - map_.at(p, c)) * steps(f, c) <= carried_.limits[c])) return false;
    }
    return true;
  }
  bool fit_all(std::span<const Index> members) const {
    return std::all_of(members.begin(), members.end(), [&](Index f) { return fits(f); });
  }

  // Writes the map, and how far the members are off it: `4 * columns` and `columns` numbers.
  void tell(std::span<const Index> members, double* map, double* span) {
    std::fill(low_.begin(), low_.end(), 0.0);
    std::fill(high_.begin(), high_.end(), 0.0);
    for (const Index f : members)
      for (int i = 0; i < 3; ++i) {
        const Vec3 p = corner(f, i);
        const double* carried = values(f, i);
        for (std::size_t c = 0; c < columns_; ++c) {
          const double off = (carried[c] - map_.at(p, c)) * steps(f, c);
          low_[c] = std::min(low_[c], off);
          high_[c] = std::max(high_[c], off);
        }
      }
    for (std::size_t c = 0; c < columns_; ++c) {
      const Vec3 gradient = map_.gradient(c);
      span[c] = high_[c] - low_[c];
      for (const double number : {gradient.x, gradient.y, gradient.z, map_.at({0, 0, 0}, c)}) *map++ = number;
    }
  }

 private:
  Vec3 corner(Index f, int i) const { return points_[faces_[f][i]]; }
  const double* values(Index f, int i) const { return &carried_.values[columns_ * rows_.at(f, faces_[f][i])]; }
  double steps(Index f, std::size_t column) const { return carried_.steps[columns_ * part_[f] + column]; }

  std::span<const Vec3> points_;
  std::span<const Face> faces_;
  const Rows& rows_;
  std::span<const Index> part_;
  const Carried& carried_;
  std::size_t columns_;
  Map map_;
  std::vector<double> told_, low_, high_;
};

// Cuts up groups that are no charts as a whole.
class ChartGrower {
 public:
  ChartGrower(Fitter fitter, std::span<const Index> twin, std::span<const Index> group, std::size_t columns,
              Charts& charts)
      : fitter_(std::move(fitter)), twin_(twin), group_(group), columns_(columns), charts_(charts) {}

  void cut_up(std::span<const Index> members) {
    std::vector<std::pair<double, Index>> seeds;
    seeds.reserve(members.size());
    for (const Index f : members) seeds.push_back({-fitter_.area(f), f});
    std::sort(seeds.begin(), seeds.end());
    for (const auto& [size, seed] : seeds)
      if (charts_.chart_of_face[seed] == none) grow(seed);
  }

  static constexpr Index none = -1, waiting = -2;

 private:
  // The map is fitted anew whenever the region has doubled; what it then leaves out waits for another seed.
  void grow(Index seed) {
    region_.assign(1, seed);
    charts_.chart_of_face[seed] = waiting;
    fitter_.fit(region_);
    start();
    sweep();
    for (std::size_t before = 0; before != region_.size();) {
      before = region_.size();
      fitter_.fit(region_);
      sweep();
    }
    if (!keep_fitting(seed)) {
      for (const Index f : region_) charts_.chart_of_face[f] = none;
      region_.assign(1, seed);
      fitter_.fit(region_);
    }
    const Index chart = static_cast<Index>(charts_.spans.size() / columns_);
    for (const Index f : region_) charts_.chart_of_face[f] = chart;
    charts_.spans.resize(charts_.spans.size() + columns_);
    charts_.maps.resize(charts_.maps.size() + 4 * columns_);
    fitter_.tell(region_, &charts_.maps[4 * columns_ * chart], &charts_.spans[columns_ * chart]);
  }

  // Adds neighbours for as long as one map fits all.
  void start() {
    for (std::size_t front = 0; front < region_.size(); ++front)
      for (int i = 0; i < 3 && region_.size() < small_region; ++i) {
        const Index t = twin_[3 * region_[front] + i];
        if (t < 0 || !may_join(t / 3)) continue;
        region_.push_back(t / 3);
        fitter_.fit(region_);
        if (fitter_.fit_all(region_))
          charts_.chart_of_face[t / 3] = waiting;
        else
          region_.pop_back();
      }
    fitter_.fit(region_);
  }

  bool may_join(Index f) const { return charts_.chart_of_face[f] == none && group_[f] == group_[region_[0]]; }

  // Adds what fits, from neighbour to neighbour.
  void sweep() {
    std::size_t next_fit = 2 * region_.size();
    for (std::size_t front = 0; front < region_.size(); ++front)
      for (int i = 0; i < 3; ++i) {
        const Index t = twin_[3 * region_[front] + i];
        if (t < 0) continue;
        const Index f = t / 3;
        if (!may_join(f) || !fitter_.fits(f)) continue;
        charts_.chart_of_face[f] = waiting;
        region_.push_back(f);
        fitter_.add(f);
        if (region_.size() >= next_fit) {
          fitter_.settle(f);
          next_fit *= 2;
        }
      }
  }

  // Leaves out what the last map does not fit; false where that is the seed.
  bool keep_fitting(Index seed) {
    if (!fitter_.fits(seed)) return false;
    const auto end = std::remove_if(region_.begin(), region_.end(), [&](Index f) {
      if (fitter_.fits(f)) return false;
      charts_.chart_of_face[f] = none;
      return true;
    });
    region_.erase(end, region_.end());
    return true;
  }

  Fitter fitter_;
  std::span<const Index> twin_;
  std::span<const Index> group_;
  std::size_t columns_;
  Charts& charts_;
  std::vector<Index> region_;
};

}  // namespace

Charts find_charts(std::span<const Vec3> points, std::span<const Face> faces, std::span<const Index> twin,
                   std::span<const Index> start, std::span<const Index> order, const Rows& rows,
                   std::span<const Index> part_of_face, const Carried& carried) {
  const std::size_t groups = start.size() - 1, columns = carried.limits.size();
  const auto members = [&](std::size_t g) { return order.subspan(start[g], start[g + 1] - start[g]); };
  const Fitter fitter(points, faces, rows, part_of_face, carried);
  // The chart of group g, if it is one, is number g.
  Charts charts{Array<Index>(faces.size()), std::vector<double>(4 * columns * groups),
                std::vector<double>(columns * groups)};
  Array<Index> group(faces.size());
  std::vector<std::uint8_t> whole(groups, 1);
  const std::size_t average = faces.size() / std::max<std::size_t>(groups, 1) + 1;
  parallel_for(
      groups,
      [&](std::size_t first, std::size_t last) {
        Fitter own = fitter;
        for (std::size_t g = first; g < last; ++g) {
          const std::span<const Index> all = members(g);
          if (all.empty()) continue;
          own.fit(all);
          whole[g] = own.fit_all(all);
          if (whole[g]) own.tell(all, &charts.maps[4 * columns * g], &charts.spans[columns * g]);
          for (const Index f : all) {
            group[f] = static_cast<Index>(g);
            charts.chart_of_face[f] = whole[g] ? static_cast<Index>(g) : ChartGrower::none;
          }
        }
      },
      std::max<std::size_t>(least_parallel_work / average, 1));
  ChartGrower grower(fitter, twin, group, columns, charts);
  for (std::size_t g = 0; g < groups; ++g)
    if (!whole[g]) grower.cut_up(members(g));
  return charts;
}

Array<Index> find_smooth(std::span<const Vec3> points, std::span<const Face> faces, std::span<const Index> twin,
                         const Rows& rows, std::span<const Vec3> normals, double cosine, double needle) {
  const auto is_needle = [&](Index f) {
    const Vec3 a = points[faces[f][0]], b = points[faces[f][1]], c = points[faces[f][2]];
    return length(cross(b - a, c - a)) <= needle * std::max({length(b - a), length(c - b), length(a - c)});
  };
  const auto smooth = [&](Index f, Index g, Index point) {
    const Vec3 a = normals[rows.at(f, point)], b = normals[rows.at(g, point)];
    return dot(a, b) >= cosine * length(a) * length(b);
  };
  return join_across(twin, [&](Index h, Index t) {
    const Index f = h / 3, g = t / 3;
    return (smooth(f, g, faces[f][h % 3]) && smooth(f, g, faces[g][t % 3])) || is_needle(f) || is_needle(g);
  });
}

}  // namespace bldsimp
