#include <algorithm>
#include <limits>

#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks::scorers {

std::vector<ViewpointIndex> viewpoints_of(const Trajectory& trajectory) {
  std::vector<ViewpointIndex> viewpoints;
  viewpoints.reserve(trajectory.points.size());
  for (const TrajectoryPoint& point : trajectory.points) viewpoints.push_back(point.viewpoint);
  return viewpoints;
}

double nearest(const graph::NavGraph& graph, ViewpointIndex from,
               std::span<const ViewpointIndex> to) {
  double least = std::numeric_limits<double>::infinity();
  for (const ViewpointIndex one : to) least = std::min(least, graph.distance(from, one));
  return least;
}

double action_steps(const Trajectory& trajectory) {
  return static_cast<double>(trajectory.actions.value_or(trajectory.points.size() - 1));
}

double spl(bool success, double length, double walked, double guard) {
  const double divisor = std::max({walked, length, guard});
  return success && divisor > 0 ? length / divisor : 0;
}

}  // namespace enfilade::tasks::scorers
