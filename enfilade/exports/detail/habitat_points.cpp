#include "enfilade/exports/detail/habitat_points.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "enfilade/geometry/habitat_frame.h"

namespace enfilade::exports::detail {

IslandDraw::IslandDraw(const HabitatIsland& island)
    : island_(island), triangles_(island.floor.triangles(island.island)) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles_) {
    sum += length(cross(to_double(b - a), to_double(c - a))) / 2;
    up_to_.push_back(sum);
  }
}

std::optional<Vec3f> IslandDraw::draw(Rng& rng) const {
  if (triangles_.empty()) return std::nullopt;
  const double at = rng.uniform() * up_to_.back();
  const auto found = std::ranges::upper_bound(up_to_, at);
  const std::size_t k =
      std::min(static_cast<std::size_t>(found - up_to_.begin()), triangles_.size() - 1);
  const auto& [a, b, c] = triangles_[k];
  // Uniform over the triangle: the square root makes up for its narrow end.
  const double out = std::sqrt(rng.uniform()), along = rng.uniform();
  const Vec3d point =
      to_double(a) + out * ((1 - along) * to_double(b - a) + along * to_double(c - a));
  return on_island(island_, to_float(point));
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
