#include "details/features.hpp"

#include <map>
#include <set>

#include "details/facet_slide.hpp"
#include "details/feature_search.hpp"
#include "mesh/certificate.hpp"
#include "mesh/crossings.hpp"

namespace bldsimp {
namespace {

constexpr int kMostRounds = 24;

// A face of what is left, and the input face that it was or continues.
struct CurrentFace {
  Face face;
  Index source;
  bool changed;  // else it is the input face itself
};

// What is left once some candidates have gone.
struct Trial {
  std::vector<Vec3> points, stored;  // about the middle, and as written
  std::vector<CurrentFace> faces;
  std::vector<Index> owner;  // of each face: the candidate that made or moved it, or -1
  std::size_t kept = 0;      // faces that were there before come first
};

bool meet(const std::vector<Index>& a, const std::vector<Index>& b) {
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j) return true;
    *i < *j ? ++i : ++j;
  }
  return false;
}

Box widen(Box box, double around) {
  const Vec3 way{around, around, around};
  return {box.low - way, box.high + way};
}

class FeatureRemover {
 public:
  explicit FeatureRemover(const FeatureInput& input);

  FeatureRemoval run() {
    // What can be closed goes before anything slides: else what is left of a detail would be deeper than before.
    for (int round = 0; round < kMostRounds; ++round) {
      const bool found = run_round();
      if (!found && slides_) break;
      slides_ = !found;
    }
    return take_result();
  }

 private:
  bool run_round();
  void find_candidates();
  bool try_closing(const std::vector<Index>& facets, const std::vector<Loop>& loops);
  void try_slides(Index facet);
  bool try_slide(Index facet, Index plane, std::uint64_t id);
  bool accept(FeatureCandidate candidate);
  bool may_go(Indices faces) const;
  bool keeps_parts(const Caps& caps) const;
  bool keeps_labels(const FeatureCandidate& candidate) const;
  bool is_allowed(const FeatureCandidate& candidate) const;
  bool gains(const FeatureCandidate& candidate) const;
  bool keeps_topology(const FeatureCandidate& candidate) const;
  bool overlaps(const FeatureCandidate& candidate) const;
  bool caps_hold(const FeatureCandidate& candidate);
  bool rest_holds(const FeatureCandidate& candidate);
  Box measure_box(const FeatureCandidate& candidate) const;
  Trial try_all() const;
  std::vector<std::size_t> find_failures(const Trial& trial);
  void blame_faces(const Trial& trial, Faces faces, std::vector<std::size_t>& failures);
  void blame_edges(const Trial& trial, Faces faces, std::vector<std::size_t>& failures);
  std::size_t find_last(const Box& box) const;
  void blame_missing(const Trial& trial, Faces faces, std::vector<std::size_t>& failures) const;
  void commit(Trial trial);
  FeatureRemoval take_result();

  FeatureInput input_;
  Vec3 middle_{0, 0, 0};
  std::vector<Vec3> given_, points_, stored_;  // about the middle: of the input, of what is left; as written
  std::vector<CurrentFace> faces_;
  std::vector<IndexPair> part_points_;  // {point, part of a face at it}, sorted
  FaceTree tree_;                       // of the input
  Certificate near_input_{tree_};
  FaceTree rim_tree_;  // of its open edges
  Certificate near_rim_{rim_tree_};
  std::map<Index, Index> label_count_, label_going_;  // faces of each label; those that go more than come
  std::ptrdiff_t growth_ = 0;                         // triangles that come more than go
  std::set<std::uint64_t> refused_, failed_;          // candidates for good, and those that failed among others
  std::array<std::set<std::uint64_t>, 2> exhausted_;  // seeds, without slides and with them
  bool slides_ = false;
  Triangulator triangulator_;
  FeatureRemoval result_;

  // Of the round.
  std::vector<Face> now_;
  std::vector<Index> now_label_;
  std::optional<FacetGraph> graph_;
  std::optional<LoopCloser> closer_;
  std::optional<BoxTree> near_;
  std::vector<FeatureCandidate> accepted_;
};

FeatureRemover::FeatureRemover(const FeatureInput& input)
    : input_(input), given_(about_middle(input.points)), points_(given_),
      stored_(input.points.begin(), input.points.end()), tree_(given_, input.faces),
      rim_tree_(given_, find_open_edges(input.faces, static_cast<Index>(input.points.size()))) {
  if (!input.points.empty()) middle_ = input.points[input.points.size() / 2];
  for (std::size_t f = 0; f < input.faces.size(); ++f)
    for (const Index p : input.faces[f]) part_points_.push_back({p, input.part[f]});
  sort_unique(part_points_);
  for (std::size_t f = 0; f < input.faces.size(); ++f) {
    if (input.left_out[f]) continue;
    faces_.push_back({input.faces[f], static_cast<Index>(f), false});
    ++label_count_[input.label[f]];
  }
}

bool FeatureRemover::run_round() {
  find_candidates();
  const bool found = !accepted_.empty();
  while (!accepted_.empty()) {
    Trial trial = try_all();
    const auto failures = find_failures(trial);
    if (failures.empty()) {
      commit(std::move(trial));
      return true;
    }
    // What fails among others may go after them; what fails alone, or twice, never will.
    for (auto i = failures.rbegin(); i != failures.rend(); ++i) {
      const std::uint64_t id = accepted_[*i].id;
      if (accepted_.size() == 1 || !failed_.insert(id).second) refused_.insert(id);
      accepted_.erase(accepted_.begin() + static_cast<std::ptrdiff_t>(*i));
    }
  }
  return found;
}

void FeatureRemover::find_candidates() {
  now_.clear(), now_label_.clear(), accepted_.clear(), label_going_.clear();
  growth_ = 0;
  for (const CurrentFace& f : faces_) now_.push_back(f.face), now_label_.push_back(input_.label[f.source]);
  graph_.emplace(points_, now_, now_label_, input_.flat);
  closer_.emplace(*graph_);
  near_.emplace(points_, now_, list_indices(now_.size()));
  FeatureSearch(*graph_, *closer_, input_.limit).run(exhausted_[slides_], [&](const auto& facets, const auto& loops) {
    return try_closing(facets, loops);
  });
  if (slides_)
    for (Index k = 0; k < graph_->facet_count(); ++k) try_slides(k);
  if (!input_.keep_topology)
    for (const Loop& loop : graph_->find_open_loops()) try_closing({}, {loop});
}

// No pinned face, and not the last one of any label.
bool FeatureRemover::may_go(Indices faces) const {
  std::map<Index, Index> going = label_going_;
  for (const Index f : faces) {
    if (input_.stays[faces_[f].source]) return false;
    ++going[now_label_[f]];
  }
  return std::all_of(going.begin(), going.end(),
                     [&](const auto& one) { return one.second < label_count_.at(one.first); });
}

// Whether what goes has a label of the caps, or is so narrow that the border of its label moves by the limit at most.
bool FeatureRemover::keeps_labels(const FeatureCandidate& candidate) const {
  return std::all_of(candidate.facets.begin(), candidate.facets.end(), [&](Index k) {
    const auto& parents = candidate.caps.parent;
    return std::any_of(parents.begin(), parents.end(),
                       [&](Index f) { return now_label_[f] == graph_->shape(k).label; }) ||
           graph_->width_of(k) <= 2 * input_.limit;
  });
}

bool FeatureRemover::try_closing(const std::vector<Index>& facets, const std::vector<Loop>& loops) {
  FeatureCandidate candidate{};
  candidate.id = identify(*graph_, facets, loops) + slides_;
  if (refused_.contains(candidate.id)) return false;
  candidate.kind = facets.empty()     ? FeatureKind::boundary_loop
                   : loops.size() > 1 ? FeatureKind::passage
                                      : FeatureKind::detail;
  candidate.facets = facets;
  for (const Index k : facets) append(candidate.faces, graph_->faces_of(k));
  std::sort(candidate.faces.begin(), candidate.faces.end());
  const auto caps = !may_go(candidate.faces) ? std::nullopt
                    : facets.empty()         ? closer_->close_open(loops[0])
                                             : closer_->close(loops, facets, slides_ ? input_.limit : 0);
  // What needs no cap is a body, or a part of one that hangs in the air.
  if (!caps || caps->faces.empty()) {
    result_.kept_by_label += !caps && closer_->why() == Unclosed::label;
    refused_.insert(candidate.id);
    return false;
  }
  candidate.caps = *caps;
  for (const Loop& loop : loops)
    for (const LoopEdge& e : loop) {
      candidate.points.push_back(e.from);
      if (e.outside >= 0) candidate.around.push_back(graph_->facet_of(e.outside));
    }
  return accept(std::move(candidate));
}

// Slides a facet into the nearest plane that it can.
void FeatureRemover::try_slides(Index facet) {
  for (const Index plane : find_slide_planes(*graph_, facet, input_.limit)) {
    const std::uint64_t id = identify(*graph_, {facet, plane}, {});
    if (!refused_.contains(id) && try_slide(facet, plane, id)) return;
  }
}

bool FeatureRemover::try_slide(Index facet, Index plane, std::uint64_t id) {
  const auto slide = slide_facet(*graph_, triangulator_, facet, plane, input_.limit);
  const auto stays = [&](Index f) { return input_.stays[faces_[f].source] != 0; };
  if (!slide || std::any_of(slide->gone.begin(), slide->gone.end(), stays)) {
    refused_.insert(id);
    return false;
  }
  FeatureCandidate candidate{FeatureKind::step, id, {facet}, slide->gone, {}, {}, slide->caps};
  for (const Index f : slide->gone)
    if (graph_->facet_of(f) != facet) candidate.around.push_back(graph_->facet_of(f));
  return accept(std::move(candidate));
}

bool FeatureRemover::accept(FeatureCandidate candidate) {
  for (const Index f : candidate.faces) append(candidate.points, now_[f]);
  sort_unique(candidate.points);
  sort_unique(candidate.around);
  // Another one may go first; this is looked at again in the next round.
  if (overlaps(candidate)) return false;
  if (!is_allowed(candidate) || !caps_hold(candidate) || !rest_holds(candidate)) {
    refused_.insert(candidate.id);
    return false;
  }
  growth_ += std::ssize(candidate.caps.faces) - std::ssize(candidate.faces);
  for (const Index f : candidate.faces) ++label_going_[now_label_[f]];
  for (const Index f : candidate.caps.parent) --label_going_[now_label_[f]];
  accepted_.push_back(std::move(candidate));
  return true;
}

bool FeatureRemover::keeps_parts(const Caps& caps) const {
  for (std::size_t c = 0; c < caps.faces.size(); ++c)
    for (const Index p : caps.faces[c]) {
      const IndexPair own{p, input_.part[faces_[caps.parent[c]].source]};
      if (input_.has_many_rows[p] && !std::binary_search(part_points_.begin(), part_points_.end(), own)) return false;
    }
  return true;
}

bool FeatureRemover::is_allowed(const FeatureCandidate& candidate) const {
  const auto is_free = [&](const std::pair<Index, Vec3>& moved) {
    const Indices star = graph_->faces_at(moved.first);
    return std::none_of(star.begin(), star.end(), [&](Index f) { return input_.stays[faces_[f].source] != 0; });
  };
  if (!candidate.caps.moved.empty() && input_.rounding.decimals < 0) return false;
  return std::all_of(candidate.caps.moved.begin(), candidate.caps.moved.end(), is_free) && gains(candidate) &&
         keeps_parts(candidate.caps) && keeps_labels(candidate) && (!input_.keep_topology || keeps_topology(candidate));
}

// Whether fewer triangles are left, or as many in fewer planes; what closes open edges may cost some.
bool FeatureRemover::gains(const FeatureCandidate& candidate) const {
  const auto more = std::ssize(candidate.caps.faces) - std::ssize(candidate.faces);
  if (candidate.kind == FeatureKind::boundary_loop)
    return std::ssize(now_) + growth_ + more <= static_cast<std::ptrdiff_t>(input_.most_triangles);
  if (more != 0 || candidate.kind == FeatureKind::step) return more < 0;
  return std::none_of(candidate.facets.begin(), candidate.facets.end(), [&](Index k) {
    return std::any_of(candidate.around.begin(), candidate.around.end(),
                       [&](Index other) { return graph_->share_plane(k, other); });
  });
}

bool FeatureRemover::keeps_topology(const FeatureCandidate& candidate) const {
  std::vector<Face> gone;
  for (const Index f : candidate.faces) gone.push_back(now_[f]);
  return count_euler(gone) == count_euler(candidate.caps.faces);
}

bool FeatureRemover::overlaps(const FeatureCandidate& candidate) const {
  const auto moves = [](const FeatureCandidate& c) { return c.kind == FeatureKind::step || !c.caps.moved.empty(); };
  return std::any_of(accepted_.begin(), accepted_.end(), [&](const FeatureCandidate& other) {
    return meet(candidate.faces, other.faces) || meet(candidate.facets, other.facets) ||
           meet(candidate.facets, other.around) || meet(candidate.around, other.facets) ||
           ((moves(candidate) || moves(other)) && meet(candidate.points, other.points));
  });
}

// Whether the caps are within the limit of the input.
bool FeatureRemover::caps_hold(const FeatureCandidate& candidate) {
  const auto at = [&](Index p) { return candidate.place_of(p, points_); };
  return std::all_of(candidate.caps.faces.begin(), candidate.caps.faces.end(),
                     [&](const Face& f) { return near_input_.holds({at(f[0]), at(f[1]), at(f[2])}, input_.limit); });
}

Box FeatureRemover::measure_box(const FeatureCandidate& candidate) const {
  Box box;
  for (const Index p : candidate.points) box.add(points_[p]);
  return box;
}

// Whether the input faces that would go are within the limit of the caps and what stays nearby.
bool FeatureRemover::rest_holds(const FeatureCandidate& candidate) {
  if (candidate.faces.empty()) return true;
  std::vector<Vec3> points;
  std::vector<Face> rest;
  const auto add = [&](const Face& face) {
    const auto first = static_cast<Index>(points.size());
    for (const Index p : face) points.push_back(candidate.place_of(p, points_));
    rest.push_back({first, first + 1, first + 2});
  };
  for (const Face& face : candidate.caps.faces) add(face);
  near_->visit(widen(measure_box(candidate), input_.limit), [&](Index i) {
    const Index f = near_->order()[i];
    if (!std::binary_search(candidate.faces.begin(), candidate.faces.end(), f)) add(now_[f]);
    return true;
  });
  const FaceTree tree(points, rest);
  Certificate near_rest(tree);
  return std::all_of(candidate.faces.begin(), candidate.faces.end(), [&](Index f) {
    return faces_[f].changed || near_rest.holds(corners_of(now_[f], points_), input_.limit);
  });
}

Trial FeatureRemover::try_all() const {
  Trial trial{points_, stored_, {}, {}, 0};
  std::vector<Index> mover(points_.size(), -1);
  std::vector<bool> goes(now_.size(), false);
  for (std::size_t i = 0; i < accepted_.size(); ++i) {
    for (const Index f : accepted_[i].faces) goes[f] = true;
    for (const auto& [p, to] : accepted_[i].caps.moved) {
      trial.stored[p] = input_.rounding(to + middle_);
      trial.points[p] = trial.stored[p] - middle_;
      mover[p] = static_cast<Index>(i);
    }
  }
  for (std::size_t f = 0; f < now_.size(); ++f) {
    if (goes[f]) continue;
    const auto& [a, b, c] = now_[f];
    trial.owner.push_back(std::max({mover[a], mover[b], mover[c]}));
    trial.faces.push_back(faces_[f]);
    trial.faces.back().changed |= trial.owner.back() >= 0;
  }
  trial.kept = trial.faces.size();
  for (std::size_t i = 0; i < accepted_.size(); ++i) {
    const Caps& caps = accepted_[i].caps;
    for (std::size_t c = 0; c < caps.faces.size(); ++c)
      trial.faces.push_back({caps.faces[c], faces_[caps.parent[c]].source, true});
    trial.owner.resize(trial.faces.size(), static_cast<Index>(i));
  }
  return trial;
}

// Candidates that together cross something, bring a face too far, or leave something without a hold.
std::vector<std::size_t> FeatureRemover::find_failures(const Trial& trial) {
  std::vector<Face> faces;
  std::vector<std::uint8_t> wanted;
  for (std::size_t f = 0; f < trial.faces.size(); ++f) {
    faces.push_back(trial.faces[f].face);
    wanted.push_back(trial.owner[f] >= 0);
  }
  std::vector<std::size_t> failures;
  for (const auto& [f, g] : find_crossings(trial.stored, faces, wanted))
    failures.push_back(static_cast<std::size_t>(std::max(trial.owner[f], trial.owner[g])));
  blame_faces(trial, faces, failures);
  blame_edges(trial, faces, failures);
  blame_missing(trial, faces, failures);
  sort_unique(failures);
  return failures;
}

// A face that is new, or has a point that moved, lies near the input, has an area, and has not turned over.
void FeatureRemover::blame_faces(const Trial& trial, Faces faces, std::vector<std::size_t>& failures) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (trial.owner[f] < 0) continue;
    const Triangle at = corners_of(faces[f], trial.points);
    const Vec3 now = area_vector(at);
    const bool turns = f < trial.kept && dot(now, area_vector(corners_of(faces[f], points_))) < 0;
    if (turns || length(now) == 0 || !near_input_.holds(at, input_.limit))
      failures.push_back(static_cast<std::size_t>(trial.owner[f]));
  }
}

// Each input face that is gone lies near what is left; else the last candidate nearby is to blame.
void FeatureRemover::blame_missing(const Trial& trial, Faces faces, std::vector<std::size_t>& failures) const {
  const FaceTree tree(trial.points, faces);
  Certificate near_trial(tree);
  std::vector<bool> there(input_.faces.size(), false);
  for (const CurrentFace& f : trial.faces)
    if (!f.changed) there[f.source] = true;
  for (std::size_t f = 0; f < there.size(); ++f) {
    const Triangle at = corners_of(input_.faces[f], given_);
    if (!there[f] && !near_trial.holds(at, input_.limit)) failures.push_back(find_last(box_of(at)));
  }
}

// The last candidate near a box.
std::size_t FeatureRemover::find_last(const Box& box) const {
  std::size_t last = accepted_.size() - 1;
  while (last > 0 && !widen(measure_box(accepted_[last]), 2 * input_.limit).meets(box)) --last;
  return last;
}

// Open edges lie near those of the input.
void FeatureRemover::blame_edges(const Trial& trial, Faces faces, std::vector<std::size_t>& failures) {
  for (const Face& edge : find_open_edges(faces, static_cast<Index>(trial.points.size()))) {
    const Triangle at = corners_of(edge, trial.points);
    if (!near_rim_.holds(at, input_.limit)) failures.push_back(find_last(box_of(at)));
  }
}

void FeatureRemover::commit(Trial trial) {
  for (const FeatureCandidate& one : accepted_) {
    Box box;
    for (const Index p : one.points) box.add(stored_[p]);
    append(result_.boxes, std::array{box.low, box.high});
    result_.kinds.push_back(static_cast<std::uint8_t>(one.kind));
    result_.triangles.push_back(static_cast<Index>(one.faces.size()));
    result_.places.push_back(faces_[one.faces.empty() ? one.caps.parent[0] : one.faces[0]].source);
  }
  points_ = std::move(trial.points), stored_ = std::move(trial.stored), faces_ = std::move(trial.faces);
  label_count_.clear();
  for (const CurrentFace& f : faces_) ++label_count_[input_.label[f.source]];
}

FeatureRemoval FeatureRemover::take_result() {
  result_.points = stored_;
  result_.left_out.assign(input_.faces.size(), 1);
  for (const CurrentFace& f : faces_) {
    if (f.changed) {
      result_.faces.push_back(f.face);
      result_.parent.push_back(f.source);
    } else {
      result_.left_out[f.source] = 0;
    }
  }
  return std::move(result_);
}

}  // namespace

FeatureRemoval remove_features(const FeatureInput& input) { return FeatureRemover(input).run(); }

}  // namespace bldsimp
