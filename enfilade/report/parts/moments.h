/// \file  An agent's way through an episode, moment by moment, as the page's gallery shows it.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "enfilade/geometry/angle.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/models/decisions.h"
#include "enfilade/tasks/results.h"

namespace enfilade::report::parts {

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
nlohmann::ordered_json moment_json(const Moment& moment, const graph::NavGraph& graph);

/// A value as the page has it: rounded to a multiple of `unit`.
double rounded(double value, double unit);

}  // namespace enfilade::report::parts
