/// \file  How far a viewpoint is from the goal of an episode, of any kind, and whether the goal is
/// reached. Oracles, rewards, drawings and own_scorer() use it; public scorers have rules of their
/// own: scorer.h.
#pragma once
#include <cstdint>
#include <optional>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::tasks {

/// R2R-Back has two legs: to the turning point, and from there to the end. All others have the last
/// one only, whichever is given.
enum class Leg : std::uint8_t { kOut, kBack };

/// Metres along the graph from a viewpoint to the nearest one that satisfies the goal. That is the
/// path's end, a viewpoint that sees the object, one of the region, or one that has a box. R2R-Back
/// measures through the turning point to the end (kOut), or to the end (kBack). NaN if the goal is
/// hidden, +inf if it is out of reach or no viewpoint sees the object. O(viewpoints of the goal).
/// \pre from < graph.size()
double distance_to_goal(const graph::NavGraph& graph, const ReferencePath& path,
                        ViewpointIndex from, Leg leg = Leg::kOut);

/// The nearest viewpoint that satisfies the goal. Among equally near ones it is the first in the
/// goal's order. R2R-Back has the turning point (kOut), then the end (kBack). No value if the goal
/// is hidden or out of reach.
/// \pre from < graph.size()
std::optional<ViewpointIndex> nearest_goal(const graph::NavGraph& graph, const ReferencePath& path,
                                           ViewpointIndex from, Leg leg = Leg::kOut);

/// The leg after a visit of a viewpoint: kBack once it is within `radius` metres of the turning
/// point. The radius itself is included, as in R2R-Back's public scorer.
Leg leg_after(const graph::NavGraph& graph, const ReferencePath& path, ViewpointIndex at, Leg leg,
              double radius);

/// Whether an agent that stops at a viewpoint succeeds, as in the benchmark's first public scorer.
/// Answers do not count. False if the goal is hidden. The rule, by goal:
/// - path's end (R2R and the benchmarks made from it): nearer than `radius` metres to it
/// - turning point (R2R-Back): on the way back, at most `radius` metres from the path's end
/// - object: at a viewpoint that sees it
/// - region: in it
/// - boxes (SOON): at a viewpoint with a box, or nearer than `radius` metres to the path's end
/// \pre at < graph.size()
bool goal_reached(const graph::NavGraph& graph, const ReferencePath& path, ViewpointIndex at,
                  Leg leg, double radius);

/// The measures of a trajectory by its episode's goal. Answers do not count, except R2R-Back's.
struct GoalOutcome {
  double error = 0;         ///< metres from its end: distance_to_goal()
  double oracle_error = 0;  ///< least over its viewpoints
  bool reached = false;     ///< goal_reached() at its end
  bool oracle_reached = false;
  double shortest = 0;  ///< shortest_to_goal()
};
/// R2R-Back's agent is on its way back if the turning point that it names is within `radius` of the
/// goal's. Then viewpoints count from the first one that is within `radius` of it.
/// \pre the goal is not hidden, the trajectory is not empty
GoalOutcome judge(const graph::NavGraph& graph, const ReferencePath& path,
                  const Trajectory& trajectory, double radius);

/// The shortest length that SPL compares the trajectory's length with, metres. NaN if the goal is
/// hidden. It is the distance from the path's start to its end, with these exceptions:
/// - R2R-Back: through the turning point
/// - CVDN: to the nearest viewpoint of the region
/// - SOON: to `end`, the viewpoint where the agent stopped, if that has a box
double shortest_to_goal(const graph::NavGraph& graph, const ReferencePath& path,
                        ViewpointIndex end);

}  // namespace enfilade::tasks
