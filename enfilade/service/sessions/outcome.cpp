#include "enfilade/service/sessions/outcome.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "enfilade/draw/planned_goal.h"
#include "enfilade/service/detail/goal_kinds.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/tasks/goal.h"
#include "enfilade/tasks/goal_distance.h"
#include "enfilade/tasks/metrics.h"

namespace enfilade::service::sessions {
namespace {

using nlohmann::ordered_json;

ordered_json metres(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json();
}

std::vector<ViewpointIndex> viewpoints_of(const tasks::Trajectory& trajectory) {
  std::vector<ViewpointIndex> walk;
  for (const tasks::TrajectoryPoint& point : trajectory.points) {
    if (walk.empty() || walk.back() != point.viewpoint) walk.push_back(point.viewpoint);
  }
  return walk;
}

}  // namespace

ordered_json outcome_json(const tasks::EpisodeSet& episodes, const tasks::Trajectory& trajectory) {
  const tasks::Episode& episode = episodes.episodes.at(trajectory.episode);
  const tasks::ReferencePath& path = episodes.path_of(episode);
  const graph::NavGraph& graph = episodes.graph_of(episode);
  const double radius = tasks::MetricOptions().success_distance;
  const tasks::GoalOutcome judged = tasks::judge(graph, path, trajectory, radius);
  const std::vector<ViewpointIndex> walk = viewpoints_of(trajectory);
  const auto ids = [&graph](const std::vector<ViewpointIndex>& viewpoints) {
    return detail::json_list(viewpoints, [&graph](ViewpointIndex v) { return graph.id(v); });
  };
  const auto goal = draw::planned_goal(path);
  ordered_json out{{"scan", graph.scan()},
                   {"kind", detail::name_of_kind(path.goal)},
                   {"path", ids(path.viewpoints)},
                   {"walk", ids(walk)},
                   {"viewpoints", goal ? ids(goal->viewpoints) : ordered_json::array()},
                   {"length", metres(tasks::walked(graph, walk))},
                   {"shortest", metres(judged.shortest)},
                   {"error", metres(judged.error)},
                   {"oracle_error", metres(judged.oracle_error)},
                   {"success", judged.reached},
                   {"oracle_success", judged.oracle_reached},
                   {"success_distance", radius}};
  if (const auto* object = std::get_if<tasks::SeenObject>(&path.goal)) {
    out["answer"] = trajectory.object.empty()
                        ? ordered_json()
                        : ordered_json(trajectory.object == std::to_string(object->id));
  }
  return out;
}

}  // namespace enfilade::service::sessions
