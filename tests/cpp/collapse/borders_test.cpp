// Borders: edges of other than two faces, and edges between labels.
#include "collapse/borders.hpp"

#include <map>

#include "check.hpp"
#include "shapes.hpp"

using namespace bldsimp;
using shapes::Random;
using shapes::Soup;

namespace {

void borders_are_those_of_a_plain_search() {
  Random random(1);
  for (int round = 0; round < 60; ++round) {
    Soup soup = round % 2 ? shapes::block_with_windows(random, 3, 0.4, 1) : shapes::noisy_sheet(random, 7, 0.1, 0.1);
    std::vector<Index> label;
    for (std::size_t f = 0; f < soup.faces.size(); ++f) label.push_back(shapes::below(random, 2));
    std::map<Face, std::vector<Index>> same;  // by sorted corners
    const auto copies = static_cast<std::size_t>(round % 5);
    for (std::size_t i = 0; i < copies && i < soup.faces.size(); ++i) {
      auto [a, b, c] = soup.faces[2 * i];
      soup.faces.push_back({a, c, b});
      label.push_back(shapes::below(random, 2));
    }
    const DistinctFaces distinct = merge_copies(soup.faces);
    for (std::size_t f = 0; f < soup.faces.size(); ++f)
      same[sort_corners(soup.faces[f])].push_back(static_cast<Index>(f));
    CHECK(distinct.faces.size() == same.size());
    for (std::size_t f = 0; f < distinct.faces.size(); ++f) {
      const auto& all = same[sort_corners(distinct.faces[f])];
      CHECK(distinct.faces[f] == soup.faces[all[0]] && distinct.index[f] == all[0]);
      CHECK(distinct.copy[f] == (all.size() > 1 ? all[1] : -1));
    }
    const auto labels = pair_labels(distinct, label);
    std::map<Edge, std::vector<Labels>> edges;
    for (std::size_t f = 0; f < distinct.faces.size(); ++f)
      for (int i = 0; i < 3; ++i) {
        const auto [low, high] = std::minmax({distinct.faces[f][i], distinct.faces[f][(i + 1) % 3]});
        edges[{low, high}].push_back(labels[f]);
      }
    const auto found = find_border_edges(distinct.faces, soup.points.size(), labels);
    std::size_t borders = 0, flat = 0;
    for (auto& [edge, own] : edges) {
      if (own.size() == 2 && own[0] == own[1]) continue;
      ++borders;
      std::sort(own.begin(), own.end());
      const int kind = own.size() == 1 && own[0][1] < 0 ? 0 : own.size() == 2 ? 1 : 2;
      const auto at = std::find_if(found.begin(), found.end(), [&](const BorderEdge& e) {
        return std::minmax(e.ends[0], e.ends[1]) == std::minmax(edge[0], edge[1]);
      });
      CHECK(at != found.end() && at->kind == kind && at->labels == own);
    }
    CHECK(found.size() == borders);
    for (int kind = 0; kind < edge_kinds; ++kind)
      for (const Face& face : flatten_edges(found, kind)) flat += face[1] == face[2];
    CHECK(flat == borders);
  }
}

void nothing_has_no_borders() { CHECK(find_border_edges({}, 0, {}).empty() && merge_copies({}).faces.empty()); }

}  // namespace

int main() {
  RUN(borders_are_those_of_a_plain_search);
  RUN(nothing_has_no_borders);
  return check::report();
}
