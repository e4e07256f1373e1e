#include "enfilade/tasks/goal_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <variant>
#include <vector>

namespace enfilade::tasks {
namespace {

constexpr double kOutOfReach = std::numeric_limits<double>::infinity();

struct Nearest {
  double distance = kOutOfReach;
  std::optional<ViewpointIndex> viewpoint;

  void offer(ViewpointIndex candidate, double metres) {
    if (metres < distance) *this = {metres, candidate};
  }
};

bool has_box(const Boxes& goal, ViewpointIndex at) {
  return std::ranges::find(goal.boxes, at, &Box::viewpoint) != goal.boxes.end();
}

// The nearest viewpoint that satisfies a goal, by its kind.
class Search {
 public:
  Search(const graph::NavGraph& graph, const ReferencePath& path, ViewpointIndex from, Leg leg)
      : graph_(graph), path_(path), from_(from), leg_(leg) {}

  Nearest run() {
    std::visit([this](const auto& goal) { look(goal); }, path_.goal);
    return nearest_;
  }

 private:
  void offer(ViewpointIndex candidate) {
    nearest_.offer(candidate, graph_.distance(from_, candidate));
  }
  void look(const HiddenGoal& /*goal*/) {}
  void look(const NearEnd& /*goal*/) { offer(path_.viewpoints.back()); }
  void look(const TurningPoint& goal) {
    offer(leg_ == Leg::kOut ? goal.viewpoint : path_.viewpoints.back());
  }
  void look(const SeenObject& goal) { offer_all(goal.seen_from); }
  void look(const Region& goal) { offer_all(goal.viewpoints); }
  void look(const Boxes& goal) {
    for (const Box& box : goal.boxes) offer(box.viewpoint);
    // Released files have items without a box: then the path's end is all that there is.
    if (goal.boxes.empty()) offer(path_.viewpoints.back());
  }
  void offer_all(std::span<const ViewpointIndex> candidates) {
    for (const ViewpointIndex candidate : candidates) offer(candidate);
  }

  const graph::NavGraph& graph_;
  const ReferencePath& path_;
  ViewpointIndex from_;
  Leg leg_;
  Nearest nearest_;
};

}  // namespace

double distance_to_goal(const graph::NavGraph& graph, const ReferencePath& path,
                        ViewpointIndex from, Leg leg) {
  if (goal_hidden(path)) return std::numeric_limits<double>::quiet_NaN();
  const double distance = Search(graph, path, from, leg).run().distance;
  const auto* turn = std::get_if<TurningPoint>(&path.goal);
  if (turn == nullptr || leg == Leg::kBack) return distance;
  return distance + graph.distance(turn->viewpoint, path.viewpoints.back());
}

std::optional<ViewpointIndex> nearest_goal(const graph::NavGraph& graph, const ReferencePath& path,
                                           ViewpointIndex from, Leg leg) {
  if (goal_hidden(path)) return std::nullopt;
  return Search(graph, path, from, leg).run().viewpoint;
}

Leg leg_after(const graph::NavGraph& graph, const ReferencePath& path, ViewpointIndex at, Leg leg,
              double radius) {
  const auto* turn = std::get_if<TurningPoint>(&path.goal);
  if (turn == nullptr || leg == Leg::kBack) return leg;
  return graph.distance(at, turn->viewpoint) <= radius ? Leg::kBack : Leg::kOut;
}

bool goal_reached(const graph::NavGraph& graph, const ReferencePath& path, ViewpointIndex at,
                  Leg leg, double radius) {
  if (goal_hidden(path)) return false;
  const double to_end = graph.distance(at, path.viewpoints.back());
  if (const auto* object = std::get_if<SeenObject>(&path.goal)) {
    return std::ranges::binary_search(object->seen_from, at);
  }
  if (const auto* region = std::get_if<Region>(&path.goal)) {
    return std::ranges::find(region->viewpoints, at) != region->viewpoints.end();
  }
  if (const auto* boxes = std::get_if<Boxes>(&path.goal)) {
    return has_box(*boxes, at) || to_end < radius;
  }
  if (std::holds_alternative<TurningPoint>(path.goal)) {
    return leg == Leg::kBack && to_end <= radius;
  }
  return to_end < radius;
}

double shortest_to_goal(const graph::NavGraph& graph, const ReferencePath& path,
                        ViewpointIndex end) {
  if (goal_hidden(path)) return std::numeric_limits<double>::quiet_NaN();
  const ViewpointIndex start = path.viewpoints.front();
  if (std::holds_alternative<TurningPoint>(path.goal) ||
      std::holds_alternative<Region>(path.goal)) {
    return distance_to_goal(graph, path, start);
  }
  const auto* boxes = std::get_if<Boxes>(&path.goal);
  if (boxes != nullptr && has_box(*boxes, end)) return graph.distance(start, end);
  return graph.distance(start, path.viewpoints.back());
}

GoalOutcome judge(const graph::NavGraph& graph, const ReferencePath& path,
                  const Trajectory& trajectory, double radius) {
  // On which leg it is at the end: back, if the turning point that it names is one.
  const Leg leg = trajectory.turning_point
                      ? leg_after(graph, path, *trajectory.turning_point, Leg::kOut, radius)
                      : Leg::kOut;
  const ViewpointIndex end = trajectory.points.back().viewpoint;
  GoalOutcome outcome;
  outcome.error = outcome.oracle_error = distance_to_goal(graph, path, end, leg);
  outcome.reached = outcome.oracle_reached = goal_reached(graph, path, end, leg, radius);
  Leg at = Leg::kOut;
  for (const TrajectoryPoint& point : trajectory.points) {
    // On the way out, R2R-Back's start is no end that was reached.
    at = leg_after(graph, path, point.viewpoint, at, radius);
    if (leg == Leg::kBack && at == Leg::kOut) continue;
    outcome.oracle_error =
        std::min(outcome.oracle_error, distance_to_goal(graph, path, point.viewpoint, leg));
    if (goal_reached(graph, path, point.viewpoint, leg, radius)) outcome.oracle_reached = true;
  }
  outcome.shortest = shortest_to_goal(graph, path, end);
  return outcome;
}

}  // namespace enfilade::tasks
