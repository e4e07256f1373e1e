/// \file  The page's gallery: some episodes of one run, moment by moment.
#pragma once
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "enfilade/geometry/angle.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/models/decisions.h"
#include "enfilade/report/parts/parts.h"
#include "enfilade/report/run_directory.h"
#include "enfilade/tasks/results.h"

namespace enfilade::report::parts {

/// One run, and its records beside its trajectories.
struct RunRecord {
  const ScoredRun* run = nullptr;
  std::optional<models::RecordedSplit> recorded;
};

/// The subject of the gallery.
struct GalleryRun : RunRecord {
  std::string no_attention;  ///< a sentence: why nothing is recorded.
  /// Shown beside it, if it or any of them chooses among viewpoints: other models on the same split
  /// with records.
  std::vector<RunRecord> others;

  bool shows_decisions() const;  ///< whether any chooses among viewpoints
};

/// The run with most to show; no value if there is none. The first of these rules that differs:
/// - a trained model, not another agent
/// - a model that chooses among viewpoints
/// - student-forcing
/// - val_unseen, then val_seen
/// - success, if the model chooses among viewpoints
///
/// \throws as load_recorded_split()
std::optional<GalleryRun> choose_run(const ScoredRuns& runs, const RunDirectory& found);

/// `each` of the best, of the worst and at random; one episode per path. Only those with records,
/// if there are any; of them only those of `clear` buildings, likewise. The best are successes by
/// the shortest path, from afar; the worst stopped farthest from the goal.
std::vector<ChosenEpisode> choose_episodes(const GalleryRun& gallery,
                                           const tasks::EpisodeSet& episodes,
                                           const std::set<ScanIndex>& clear, std::size_t each);

/// {"agent", "split", "buildings", "frames", "panoramas", "episodes"}. Each building has its graph
/// and its plan: {"x", "y", "storey", "storeys", "edges", "plan": [{"lines", "names"}]}. Lines are
/// {"walls", "doors", ...}, names [[name, x, y]]. Metres to the centimetre. The plan is empty where
/// nothing is known.
Json gallery_part(const GalleryRun& gallery, const tasks::EpisodeSet& episodes,
                  const std::vector<ChosenEpisode>& chosen, const dataset::Dataset& data,
                  BuildingPlans& plans);

/// The agent's pose and its next action. Pointers are into the recorded file.
struct Moment {
  ViewpointIndex viewpoint;
  Radians heading, elevation;
  /// "left", "forward", "go", "jump", "end"; empty: it is out of steps; "back": it has stopped, and
  /// the episode ends here, where stopping was most likely.
  std::string action;
  const std::vector<double>* attention = nullptr;  ///< over words; none: not recorded
  const models::DecisionStep* decision = nullptr;  ///< of agents that choose among viewpoints
};

/// From a results file, which has no actions: they follow from the poses.
std::vector<Moment> moments_of(const tasks::Trajectory& trajectory);
/// From an attention file. If the agent ran out of steps, its last pose is added.
/// \throws LookupError if a step is where the building has no viewpoint
std::vector<Moment> moments_of(const models::EpisodeAttention& attention,
                               const graph::NavGraph& graph, const tasks::Trajectory& trajectory);
/// From a decision file. The last pose is added if it is another, or the agent ran out of steps.
/// \throws likewise
std::vector<Moment> moments_of(const models::EpisodeDecisions& decisions,
                               const graph::NavGraph& graph, const tasks::Trajectory& trajectory);

/// {"v", "heading", "elevation", "action", "attention"}. A decision also has {"choices": [{"v"
/// (null: stop), "p", "map", "view", "heading", "elevation" (of neighbours)}], "chosen", "way",
/// "share", "nodes": [[v, visited, stop]], "object"}.
/// \throws LookupError for unknown viewpoints
Json moment_json(const Moment& moment, const graph::NavGraph& graph);

}  // namespace enfilade::report::parts
