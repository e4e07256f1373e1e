#include "enfilade/agents/mesh_floor.h"

#include <fmt/format.h>

#include <limits>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::agents {

using continuous::FloorPoint;

MeshFloor::MeshFloor(std::shared_ptr<const continuous::Buildings> buildings,
                     const DetourLimit& limit)
    : buildings_(std::move(buildings)), limit_(limit) {
  if (!buildings_) throw ArgumentError("buildings: null");
}

std::optional<Vec3d> MeshFloor::node_of(const graph::NavGraph& graph,
                                        ViewpointIndex viewpoint) const {
  const auto building = buildings_->find(graph.scan());
  if (!building) return std::nullopt;
  Vec3f below = graph.position(viewpoint);
  below.z -= graph.height(viewpoint);
  const auto found = buildings_->floor(*building).nearest(below, kReach);
  if (!found) return std::nullopt;
  return to_double(found->point);
}

tasks::WalkedNodes MeshFloor::walk(const graph::NavGraph& graph,
                                   std::span<const Vec3d> nodes) const {
  const auto building = buildings_->find(graph.scan());
  if (!building) return {.obstacle = "its building has no navigation mesh"};
  const continuous::Geodesics& ways = buildings_->ways(*building);
  std::vector<FloorPoint> points;
  for (const Vec3d node : nodes) {
    const auto point = ways.mesh().nearest(to_float(node), {0.05F, 0.05F});
    if (!point) return {.obstacle = "a node is not on the floor"};
    points.push_back(*point);
  }
  for (std::size_t k = 1; k < points.size(); ++k) {
    const double straight = length(nodes[k] - nodes[k - 1]);
    const double way = ways.distance(points[k - 1], points[k]);
    if (way == std::numeric_limits<double>::infinity()) {
      return {.obstacle =
                  fmt::format("there is no way from viewpoint {} to {} of the path", k, k + 1)};
    }
    if (way > limit_.times * straight && way > straight + limit_.metres) {
      return {.obstacle =
                  fmt::format("from viewpoint {} to {} of the path the way is {:.1f} m, in a "
                              "straight line {:.1f} m",
                              k, k + 1, way, straight)};
    }
  }
  return {.obstacle = {}, .geodesic_distance = ways.distance(points.front(), points.back())};
}

}  // namespace enfilade::agents
