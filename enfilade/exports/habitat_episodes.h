/// \file  Episodes of PointNav for habitat-lab on the floors that Habitat-Sim has of buildings, and
/// places of the files of its tasks. Points are in our world frame here, and in Habitat's in files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/continuous/habitat_scene_floor.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::exports {

/// The file of a split of VLN-CE, relative to the folder that habitat-lab calls `data`.
/// \param ending  of the split's name: "_gt" for the experts' walks
std::string habitat_vln_file(std::string_view split, std::string_view ending = {});

/// The part of a floor that episodes are on: what the viewpoints of a building stand on, and not
/// the ground outside or a roof.
struct HabitatIsland {
  continuous::HabitatSceneFloor floor;
  int island = 0;
};
/// No value if no viewpoint stands on the floor.
std::optional<HabitatIsland> habitat_island(continuous::HabitatSceneFloor floor,
                                            const graph::NavGraph& graph);

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
