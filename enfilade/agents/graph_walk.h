/// \file  Graph agents' trajectories in continuous environments: the loss between the two.
#pragma once
#include <memory>
#include <span>
#include <string_view>

#include "enfilade/agents/continuous_agent.h"
#include "enfilade/agents/mesh_floor.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::agents {

/// An agent that follows, in each continuous episode, the viewpoints of a graph agent's trajectory
/// for the same instruction. That is of the graph episode with its trajectory's path_id; for a path
/// with several instructions, the one with the same number. Viewpoints that are on no floor are
/// skipped.
/// \param trajectories  of graph_episodes, in any order
/// \throws ArgumentError for a continuous episode whose path or instruction has no trajectory
std::unique_ptr<ContinuousAgent> make_graph_walker(std::string_view name,
                                                   std::span<const tasks::Trajectory> trajectories,
                                                   const tasks::EpisodeSet& graph_episodes,
                                                   const tasks::ContinuousEpisodes& episodes,
                                                   const MeshFloor& floor);

}  // namespace enfilade::agents
