/// \file  The floor of continuous episodes, from navigation meshes, and graph agents' trajectories
/// on it: the loss between the two worlds.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "enfilade/agents/continuous_agent.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/derive_continuous.h"
#include "enfilade/tasks/results.h"

namespace enfilade::agents {

/// When a path from one node to the next counts as impossible for a body.
struct DetourLimit {
  /// The shortest path may be this many times the straight line ...
  double times = 2;
  double metres = 3;  ///< ... and this much longer: the edge leads over an obstacle
};

/// Whether a body can walk from node to node.
/// \param metres  length of the shortest path between two places in `nodes`; +inf: there is none
tasks::WalkedNodes walk_nodes(std::span<const Vec3d> nodes, const DetourLimit& limit,
                              const std::function<double(std::size_t, std::size_t)>& metres);
/// Where the connectivity file has the floor below a viewpoint.
Vec3f foot_of(const graph::NavGraph& graph, ViewpointIndex viewpoint);

/// Nodes on the navigation meshes of buildings. Any thread.
class MeshFloor final : public tasks::EpisodeFloor {
 public:
  /// Habitat's nodes lie up to 1.6 m beside their viewpoints.
  static constexpr continuous::Reach kReach{1.6F, 0.8F};

  /// \throws ArgumentError if `buildings` is null
  explicit MeshFloor(std::shared_ptr<const continuous::Buildings> buildings,
                     const DetourLimit& limit = {});

  /// The point of the floor nearest to where the connectivity file has it. No value where none is
  /// in kReach, or where the building has no mesh.
  std::optional<Vec3d> node_of(const graph::NavGraph& graph,
                               ViewpointIndex viewpoint) const override;
  tasks::WalkedNodes walk(const graph::NavGraph& graph,
                          std::span<const Vec3d> nodes) const override;

 private:
  std::shared_ptr<const continuous::Buildings> buildings_;
  DetourLimit limit_;
};

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
