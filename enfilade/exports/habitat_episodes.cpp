#include "enfilade/exports/habitat_episodes.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/agents/mesh_floor.h"
#include "enfilade/exports/detail/habitat_points.h"

namespace enfilade::exports {
namespace {

// Of Habitat's generator of PointNav: lengths in metres.
constexpr double kNearest = 1, kFarthest = 30, kWinding = 1.1;
constexpr float kOneStorey = 0.5F;
// Points drawn for one episode. A home gives one in three to ten draws.
constexpr std::size_t kTries = 200;

std::string scene_id(const std::string& scan) { return tasks::scene_of_scan(scan, "mp3d"); }

// Length of the path between two points that Habitat's generator takes for an episode.
std::optional<double> length_of_episode(const HabitatIsland& island, Vec3f start, Vec3f goal,
                                        Rng& rng) {
  if (std::abs(start.z - goal.z) > kOneStorey) return std::nullopt;
  const double metres = island.floor.distance(start, goal);
  if (!(metres >= kNearest && metres <= kFarthest)) return std::nullopt;
  const double ratio = metres / length(to_double(goal - start));
  const double rate = 20 * (ratio - 0.98) * (ratio - 0.98);
  if (ratio < kWinding && rng.uniform() > rate) return std::nullopt;
  return metres;
}

}  // namespace

std::string habitat_vln_file(std::string_view split, std::string_view ending) {
  return fmt::format("datasets/vln/mp3d/r2r/v1/{0}/{0}{1}.json.gz", split, ending);
}

std::optional<HabitatIsland> habitat_island(continuous::HabitatSceneFloor floor,
                                            const graph::NavGraph& graph) {
  std::vector<Vec3f> points;
  for (std::size_t v = 0; v < graph.size(); ++v) {
    const ViewpointIndex viewpoint(static_cast<std::uint32_t>(v));
    if (graph.included(viewpoint)) points.push_back(agents::foot_of(graph, viewpoint));
  }
  const std::optional<int> island = floor.island_of(points);
  if (!island) return std::nullopt;
  return HabitatIsland{std::move(floor), *island};
}

std::vector<PointGoalEpisode> draw_point_goals(const std::string& scan, const HabitatIsland& island,
                                               const HabitatDraws& draws) {
  Rng rng = detail::draws_of_scene(draws, scan, "pointnav");
  const detail::IslandDraw points(island);
  std::vector<PointGoalEpisode> episodes;
  for (std::size_t tries = 0; tries < kTries * draws.per_scene && episodes.size() < draws.per_scene;
       ++tries) {
    const auto start = points.draw(rng), goal = points.draw(rng);
    if (!start || !goal) continue;
    const auto metres = length_of_episode(island, *start, *goal, rng);
    if (!metres) continue;
    episodes.push_back({scan, *start, *goal, detail::draw_rotation(rng), *metres});
  }
  return episodes;
}

std::string point_goals_json(std::span<const PointGoalEpisode> episodes) {
  using Json = nlohmann::ordered_json;
  std::string text = R"({"episodes": [)";
  for (std::size_t k = 0; k < episodes.size(); ++k) {
    const PointGoalEpisode& e = episodes[k];
    constexpr double kRadius = 0.2;  // metres: success of PointNav
    const Json goal{{"position", detail::habitat_point(e.goal)}, {"radius", kRadius}};
    const Json episode{{"episode_id", fmt::to_string(k)},
                       {"scene_id", scene_id(e.scan)},
                       {"start_position", detail::habitat_point(e.start)},
                       {"start_rotation", detail::habitat_rotation(e.rotation)},
                       {"info", {{"geodesic_distance", e.geodesic_distance}}},
                       {"goals", Json::array({goal})}};
    text += (k == 0 ? "\n" : ",\n") + episode.dump();
  }
  return text + "]}\n";
}

}  // namespace enfilade::exports
