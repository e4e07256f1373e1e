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

/// Metres along the graph from a viewpoint to the nearest that satisfies the goal: the path's end;
/// where the object is seen; a viewpoint of the region; one that has a box; of R2R-Back through the
/// turning point to the end (kOut), or to the end (kBack). NaN if the goal is hidden, +inf if it is
/// out of reach or nobody sees the object. O(viewpoints of the goal). \pre from < graph.size()
double distance_to_goal(const graph::NavGraph& graph, const ReferencePath& path,
                        ViewpointIndex from, Leg leg = Leg::kOut);

/// The viewpoint to walk to: the nearest that satisfies the goal, of equally near ones the first in
/// the goal's order; of R2R-Back the turning point (kOut), then the end (kBack). No value if the
/// goal is hidden or out of reach. \pre as above
std::optional<ViewpointIndex> nearest_goal(const graph::NavGraph& graph, const ReferencePath& path,
                                           ViewpointIndex from, Leg leg = Leg::kOut);

/// The leg after a visit of a viewpoint: kBack once it is within `radius` metres of the turning
/// point, 3 m included as in its public scorer.
Leg leg_after(const graph::NavGraph& graph, const ReferencePath& path, ViewpointIndex at, Leg leg,
              double radius);

/// Whether an agent that stops at a viewpoint has arrived, as the benchmark's first public scorer
/// has it, answers aside: nearer than `radius` metres to the path's end (R2R and what has grown out
/// of it; of R2R-Back at most `radius`, on the way back); where the object is seen; in the region;
/// of SOON at a viewpoint with a box, or nearer than `radius` to the path's end. False if the goal
/// is hidden. \pre at < graph.size()
bool goal_reached(const graph::NavGraph& graph, const ReferencePath& path, ViewpointIndex at,
                  Leg leg, double radius);

/// How a trajectory did by its episode's goal, answers aside but for R2R-Back's.
struct GoalOutcome {
  double error = 0;         ///< metres from its end: distance_to_goal()
  double oracle_error = 0;  ///< least over its viewpoints
  bool reached = false;     ///< goal_reached() at its end
  bool oracle_reached = false;
  double shortest = 0;  ///< shortest_to_goal()
};
/// R2R-Back's agent is on its way back if the turning point that it names is within `radius` of the
/// goal's; then viewpoints count from where it came so near. \pre the goal is not hidden, the
/// trajectory is not empty
GoalOutcome judge(const graph::NavGraph& graph, const ReferencePath& path,
                  const Trajectory& trajectory, double radius);

/// What SPL compares the walked length with, metres: from the path's start to its end; of R2R-Back
/// through the turning point; of CVDN to the nearest viewpoint of the region; of SOON to `end`, the
/// viewpoint where the agent stopped, if that has a box. NaN if the goal is hidden.
double shortest_to_goal(const graph::NavGraph& graph, const ReferencePath& path,
                        ViewpointIndex end);

}  // namespace enfilade::tasks
