// CVDN's scorers: how much nearer to a region a navigator comes after a dialogue.
#include <algorithm>
#include <limits>
#include <variant>

#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks::scorers {
namespace {

using Walked = std::span<const ViewpointIndex>;

double least_distance(const graph::NavGraph& graph, Walked path, ViewpointIndex goal) {
  return nearest(graph, goal, path);  // distances are the same in both directions
}

// Goal progress from `start`, metres; negative for who goes away.
double progress(const Scored& scored, ViewpointIndex start, ViewpointIndex end) {
  const auto& region = std::get<Region>(scored.reference.goal);
  return nearest(scored.graph, start, region.viewpoints) -
         nearest(scored.graph, end, region.viewpoints);
}

// The official scorer with one of its path types.
void official(const Scored& scored, Walked chosen, Out out) {
  const auto& region = std::get<Region>(scored.reference.goal);
  if (chosen.empty() || region.planner.empty()) {
    std::ranges::fill(out, kNone);
    return;
  }
  const auto path = viewpoints_of(scored.trajectory);
  const graph::NavGraph& graph = scored.graph;
  const double error = graph.distance(path.back(), chosen.back());
  const double shortest = graph.distance(chosen.front(), chosen.back());
  const double length = walked(graph, path);
  const bool success = error < kSuccessDistance;
  out[0] = length;
  out[1] = error;
  out[2] = least_distance(graph, path, chosen.back()) < kSuccessDistance ? 1 : 0;
  out[3] = success ? 1 : 0;
  // Who has nowhere to go succeeds by staying.
  out[4] = shortest > 0 ? spl(success, shortest, length, 0) : (success && length == 0 ? 1 : 0);
  out[5] = least_distance(graph, path, region.planner.back()) < kSuccessDistance ? 1 : 0;
  out[6] = progress(scored, chosen.front(), path.back());
}

}  // namespace

void cvdn_planner(const Scored& scored, Out out) {
  official(scored, std::get<Region>(scored.reference.goal).planner, out);
}

void cvdn_player(const Scored& scored, Out out) {
  official(scored, std::get<Region>(scored.reference.goal).player, out);
}

void cvdn_trusted(const Scored& scored, Out out) {
  const auto& region = std::get<Region>(scored.reference.goal);
  const Walked player = region.player, planner = region.planner;
  // The navigator is trusted who walked, after the first viewpoint, through the planner's end.
  const bool trusted = player.size() > 1 && !planner.empty() &&
                       std::ranges::find(player.subspan(1), planner.back()) != player.end();
  official(scored, trusted ? player : planner, out);
}

void cvdn_hamt(const Scored& scored, Out out) {
  const auto& region = std::get<Region>(scored.reference.goal);
  const auto inside = [&region](ViewpointIndex v) {
    return std::ranges::find(region.viewpoints, v) != region.viewpoints.end();
  };
  const auto path = viewpoints_of(scored.trajectory);
  const double length = walked(scored.graph, path);
  const bool success = inside(path.back());
  out[0] = static_cast<double>(path.size() - 1);
  out[1] = length;
  out[2] = success ? 1 : 0;
  out[3] = std::ranges::any_of(path, inside) ? 1 : 0;
  out[4] = spl(success, nearest(scored.graph, path.front(), region.viewpoints), length, kGuard);
  out[5] = progress(scored, path.front(), path.back());
}

void cvdn_valan(const Scored& scored, Out out) {
  out[0] = progress(scored, scored.reference.viewpoints.front(),
                    scored.trajectory.points.back().viewpoint);
}

}  // namespace enfilade::tasks::scorers
