#include "enfilade/agents/mesh_floor.h"

#include <fmt/format.h>

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::agents {

using continuous::FloorPoint;

tasks::WalkedNodes walk_nodes(std::span<const Vec3d> nodes, const DetourLimit& limit,
                              const std::function<double(std::size_t, std::size_t)>& metres) {
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    const double straight = length(nodes[k] - nodes[k - 1]);
    const double way = metres(k - 1, k);
    if (way == std::numeric_limits<double>::infinity()) {
      return {.obstacle =
                  fmt::format("there is no way from viewpoint {} to {} of the path", k, k + 1)};
    }
    if (way > limit.times * straight && way > straight + limit.metres) {
      return {.obstacle =
                  fmt::format("from viewpoint {} to {} of the path the way is {:.1f} m, in a "
                              "straight line {:.1f} m",
                              k, k + 1, way, straight)};
    }
  }
  return {.obstacle = {}, .geodesic_distance = metres(0, nodes.size() - 1)};
}

Vec3f foot_of(const graph::NavGraph& graph, ViewpointIndex viewpoint) {
  Vec3f foot = graph.position(viewpoint);
  foot.z -= graph.height(viewpoint);
  return foot;
}

MeshFloor::MeshFloor(std::shared_ptr<const continuous::Buildings> buildings,
                     const DetourLimit& limit)
    : buildings_(std::move(buildings)), limit_(limit) {
  if (!buildings_) throw ArgumentError("buildings: null");
}

std::optional<Vec3d> MeshFloor::node_of(const graph::NavGraph& graph,
                                        ViewpointIndex viewpoint) const {
  const auto building = buildings_->find(graph.scan());
  if (!building) return std::nullopt;
  const auto found = buildings_->floor(*building).nearest(foot_of(graph, viewpoint), kReach);
  if (!found) return std::nullopt;
  return to_double(found->point);
}

tasks::WalkedNodes MeshFloor::walk(const graph::NavGraph& graph,
                                   std::span<const Vec3d> nodes) const {
  const auto building = buildings_->find(graph.scan());
  if (!building) return {.obstacle = "its building has no navigation mesh"};
  const continuous::Floor& floor = buildings_->floor(*building);
  std::vector<FloorPoint> points;
  for (const Vec3d node : nodes) {
    const auto point = floor.nearest(to_float(node), {0.05F, 0.05F});
    if (!point) return {.obstacle = "a node is not on the floor"};
    points.push_back(*point);
  }
  return walk_nodes(nodes, limit_, [&](std::size_t from, std::size_t to) {
    return floor.distance(points[from], points[to]);
  });
}

namespace {

using Routes = std::map<std::string, std::vector<Vec3d>, std::less<>>;

// The episodes of each path, in order, by its id as text.
using EpisodesOfPaths = std::map<std::string, std::vector<std::size_t>, std::less<>>;

EpisodesOfPaths by_path(const tasks::EpisodeSet& set) {
  EpisodesOfPaths found;
  for (std::size_t e = 0; e < set.episodes.size(); ++e) {
    found[fmt::to_string(set.path_of(set.episodes[e]).path_id)].push_back(e);
  }
  return found;
}

std::vector<Vec3d> route_of(const tasks::Trajectory& trajectory, const graph::NavGraph& graph,
                            const MeshFloor& floor) {
  std::vector<Vec3d> route;
  std::optional<ViewpointIndex> last;
  for (const tasks::TrajectoryPoint& pose : trajectory.points) {
    if (last == pose.viewpoint) continue;
    last = pose.viewpoint;
    if (const auto node = floor.node_of(graph, pose.viewpoint)) route.push_back(*node);
  }
  return route;
}

}  // namespace

std::unique_ptr<ContinuousAgent> make_graph_walker(std::string_view name,
                                                   std::span<const tasks::Trajectory> trajectories,
                                                   const tasks::EpisodeSet& graph_episodes,
                                                   const tasks::ContinuousEpisodes& episodes,
                                                   const MeshFloor& floor) {
  std::map<std::size_t, const tasks::Trajectory*> of_episode;
  for (const tasks::Trajectory& t : trajectories) of_episode[t.episode] = &t;
  const EpisodesOfPaths paths = by_path(graph_episodes);
  std::map<std::string, std::size_t> seen;  // episodes of each path so far
  Routes routes;
  for (const tasks::ContinuousEpisode& episode : episodes.episodes) {
    const std::string path = tasks::text_of(episode.trajectory_id);
    const std::size_t instruction = seen[path]++;
    const auto found = paths.find(path);
    const tasks::Trajectory* trajectory = nullptr;
    if (found != paths.end() && instruction < found->second.size()) {
      const auto made = of_episode.find(found->second[instruction]);
      if (made != of_episode.end()) trajectory = made->second;
    }
    if (trajectory == nullptr) {
      throw ArgumentError(fmt::format(
          "episode {}: the graph's split {} has no trajectory of instruction {} of path "
          "{}",
          tasks::text_of(episode.id), graph_episodes.split, instruction, path));
    }
    const tasks::Episode& of = graph_episodes.episodes[trajectory->episode];
    routes[tasks::text_of(episode.id)] = route_of(*trajectory, graph_episodes.graph_of(of), floor);
  }
  return make_route_agent(std::string(name), std::move(routes));
}

}  // namespace enfilade::agents
