/// \file  Points of Habitat's floors: drawn, and as its files have them.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>

#include "enfilade/core/rng.h"
#include "enfilade/exports/habitat_episodes.h"
#include "enfilade/geometry/triangle_draw.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::exports::detail {

/// Draws points of an island, uniformly by area. Unlike Habitat's own, they do not depend on the C
/// library.
class IslandDraw {
 public:
  /// \pre island outlives this
  explicit IslandDraw(const HabitatIsland& island);
  /// No value where the point is not on the floor to Habitat, as at some rims.
  std::optional<Vec3f> draw(Rng& rng) const;

 private:
  const HabitatIsland& island_;
  TriangleDraw triangles_;
};

/// The point of an island that a point is on already: within a centimetre beside it.
std::optional<Vec3f> on_island(const HabitatIsland& island, Vec3f point);

/// Any heading.
tasks::StartRotation draw_rotation(Rng& rng);
/// Streams of random numbers of a scene, so that no two tasks share one.
Rng draws_of_scene(const HabitatDraws& draws, const std::string& scan, std::string_view task);

nlohmann::ordered_json habitat_point(Vec3f world);                              ///< [x, y, z]
nlohmann::ordered_json habitat_rotation(const tasks::StartRotation& rotation);  ///< [x, y, z, w]

}  // namespace enfilade::exports::detail
