#include "enfilade/exports/detail/habitat_points.h"

#include <nlohmann/json.hpp>

#include "enfilade/geometry/habitat_frame.h"

namespace enfilade::exports::detail {

IslandDraw::IslandDraw(const HabitatIsland& island)
    : island_(island), triangles_(island.floor.triangles(island.island)) {}

std::optional<Vec3f> IslandDraw::draw(Rng& rng) const {
  const std::optional<Vec3f> point = triangles_.draw(rng);
  return point ? on_island(island_, *point) : std::nullopt;
}

std::optional<Vec3f> on_island(const HabitatIsland& island, Vec3f point) {
  return island.floor.nearest(point, island.island, {.aside = 0.01F, .above_below = 0.5F});
}

tasks::StartRotation draw_rotation(Rng& rng) {
  return tasks::StartRotation::of(Radians(2 * kPi * rng.uniform()));
}

Rng draws_of_scene(const HabitatDraws& draws, const std::string& scan, std::string_view task) {
  return Rng(draws.seed, stream_of(scan.data(), scan.size()), stream_of(task.data(), task.size()));
}

nlohmann::ordered_json habitat_point(Vec3f world) {
  const Vec3f p = to_habitat(world);
  return {p.x, p.y, p.z};
}

nlohmann::ordered_json habitat_rotation(const tasks::StartRotation& rotation) {
  return {rotation.x, rotation.y, rotation.z, rotation.w};
}

}  // namespace enfilade::exports::detail
