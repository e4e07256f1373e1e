/// \file  Distance of a viewpoint to an episode's goal of any kind: for oracles, rewards and
/// drawings. Scores have rules of their own: public_scorer.h.
#pragma once
#include <cstdint>
#include <optional>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks {

/// R2R-Back has two legs: to the turning point, and from there to the end. All others have the last
/// one only, whichever is given.
enum class Leg : std::uint8_t { kOut, kBack };

/// Metres along the graph from a viewpoint to the nearest that satisfies the goal:
/// - the path's end
/// - a viewpoint that sees the object (REVERIE), that is in the region (CVDN), or that has a box
///   (SOON)
/// - R2R-Back: through the turning point to the end (kOut), or to the end (kBack)
///
/// NaN if the goal is hidden, +inf if it is out of reach or no viewpoint sees the object.
/// O(viewpoints of the goal).
/// \pre from < graph.size()
double distance_to_goal(const graph::NavGraph& graph, const ReferencePath& path,
                        ViewpointIndex from, Leg leg = Leg::kOut);

/// The nearest viewpoint that satisfies the goal; among equally near ones, the first in the goal's
/// order. R2R-Back: the turning point (kOut), then the end (kBack). No value if the goal is hidden
/// or out of reach.
/// \pre from < graph.size()
std::optional<ViewpointIndex> nearest_goal(const graph::NavGraph& graph, const ReferencePath& path,
                                           ViewpointIndex from, Leg leg = Leg::kOut);

/// The leg after a visit of a viewpoint. It is kBack once the viewpoint lies within `radius` metres
/// of the turning point, 3 m included as in its public scorer.
Leg leg_after(const graph::NavGraph& graph, const ReferencePath& path, ViewpointIndex at, Leg leg,
              double radius);

/// Whether an agent that stops at a viewpoint succeeds, by the benchmark's first public scorer,
/// answers aside:
/// - R2R and its descendants: nearer than `radius` metres to the path's end
/// - R2R-Back: at most `radius`, on the way back
/// - REVERIE: the object is seen; CVDN: in the region
/// - SOON: at a viewpoint with a box, or nearer than `radius` to the path's end
///
/// False if the goal is hidden. \pre at < graph.size()
bool goal_reached(const graph::NavGraph& graph, const ReferencePath& path, ViewpointIndex at,
                  Leg leg, double radius);

/// The length that SPL compares the trajectory's with, metres: from the path's start to its end.
/// R2R-Back: through the turning point. CVDN: to the nearest viewpoint of the region. SOON: to
/// `end`, the viewpoint where the agent stopped, if that has a box. NaN if the goal is hidden.
double shortest_to_goal(const graph::NavGraph& graph, const ReferencePath& path,
                        ViewpointIndex end);

}  // namespace enfilade::tasks
