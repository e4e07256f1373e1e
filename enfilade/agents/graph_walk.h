/// \file  Walks of graph agents in the continuous world: what is lost between the two.
#pragma once
#include <memory>
#include <span>
#include <string_view>

#include "enfilade/agents/continuous_agent.h"
#include "enfilade/agents/mesh_floor.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::agents {

/// An agent that walks, in each continuous episode, through the viewpoints of the trajectory that a
/// graph agent made for the same instruction: of the graph episode with its trajectory's path_id,
/// and, where a path has several instructions, as many episodes later. Viewpoints that are on no
/// floor are passed over. \param trajectories  of graph_episodes, in any order
/// \throws ArgumentError for a continuous episode whose path or instruction has no trajectory
std::unique_ptr<ContinuousAgent> make_graph_walker(std::string_view name,
                                                   std::span<const tasks::Trajectory> trajectories,
                                                   const tasks::EpisodeSet& graph_episodes,
                                                   const tasks::ContinuousEpisodes& episodes,
                                                   const MeshFloor& floor);

}  // namespace enfilade::agents
