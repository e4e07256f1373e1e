/// \file  Episodes for habitat-lab on the floors that Habitat-Sim has of buildings: VLN-CE and
/// PointNav. Points are in our world frame here, and in Habitat's in files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/continuous/habitat_scene_floor.h"
#include "enfilade/core/ids.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/derive_continuous.h"

namespace enfilade::exports {

/// The part of a floor that episodes are on: what the viewpoints of a building stand on, and not
/// the ground outside or a roof.
struct HabitatIsland {
  continuous::HabitatSceneFloor floor;
  int island = 0;
};
/// No value if no viewpoint stands on the floor.
std::optional<HabitatIsland> habitat_island(continuous::HabitatSceneFloor floor,
                                            const graph::NavGraph& graph);

/// Nodes of VLN-CE's episodes on the islands of buildings, by scan. One thread at a time.
class HabitatEpisodeFloor final : public tasks::EpisodeFloor {
 public:
  /// \pre islands outlives this
  explicit HabitatEpisodeFloor(const std::map<std::string, HabitatIsland>& islands)
      : islands_(islands) {}

  /// The point of the island nearest to the floor below the viewpoint. No value where it is too far
  /// away (agents::MeshFloor::kReach), or where the building has no island.
  std::optional<Vec3d> node_of(const graph::NavGraph& graph,
                               ViewpointIndex viewpoint) const override;
  tasks::WalkedNodes walk(const graph::NavGraph& graph,
                          std::span<const Vec3d> nodes) const override;

 private:
  const std::map<std::string, HabitatIsland>& islands_;
};

/// How many episodes of PointNav and ObjectNav are drawn.
struct HabitatDraws {
  std::size_t per_scene = 60;  ///< of each, at most
  std::uint64_t seed = 1;
};

/// An episode of PointNav.
struct PointGoalEpisode {
  std::string scan;
  Vec3f start, goal;
  tasks::StartRotation rotation;
  double geodesic_distance = 0;  ///< metres
};
/// Draws starts and goals as Habitat's own generator does: on one storey, 1 to 30 m of path apart,
/// few of them nearly in a straight line. The same arguments give the same episodes.
std::vector<PointGoalEpisode> draw_point_goals(const std::string& scan, const HabitatIsland& island,
                                               const HabitatDraws& draws);
/// The text of a file that habitat-lab reads as `PointNav-v1`. Goals have a radius of 0.2 m.
std::string point_goals_json(std::span<const PointGoalEpisode> episodes);

}  // namespace enfilade::exports
