#include "enfilade/continuous/habitat_scene_floor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/continuous/habitat/habitat_floor.h"
#include "enfilade/continuous/habitat/nav_mesh.h"
#include "enfilade/continuous/habitat/path_finder.h"
#include "enfilade/core/check.h"
#include "enfilade/geometry/habitat_frame.h"

namespace enfilade::continuous {
namespace {

constexpr auto kPublished = habitat::Navigation::kV033;

}  // namespace

struct HabitatSceneFloor::Impl {
  habitat::PathFinder finder;
};

HabitatSceneFloor::HabitatSceneFloor(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HabitatSceneFloor::~HabitatSceneFloor() = default;
HabitatSceneFloor::HabitatSceneFloor(HabitatSceneFloor&&) noexcept = default;
HabitatSceneFloor& HabitatSceneFloor::operator=(HabitatSceneFloor&&) noexcept = default;

HabitatSceneFloor HabitatSceneFloor::of_mesh(const mesh::Mesh& mesh, mesh::UpAxis up,
                                             const mesh::Body& body) {
  const auto upright = up == mesh::UpAxis::kZ ? habitat::Upright::kZ : habitat::Upright::kY;
  habitat::NavMesh made = habitat::make_nav_mesh(habitat::triangles_of(mesh, upright),
                                                 habitat::settings_of(body), kPublished);
  return HabitatSceneFloor(
      std::make_unique<Impl>(Impl{habitat::PathFinder(std::move(made), kPublished)}));
}

HabitatSceneFloor HabitatSceneFloor::of_file(std::span<const std::uint8_t> bytes,
                                             const std::string& name) {
  return HabitatSceneFloor(std::make_unique<Impl>(
      Impl{habitat::PathFinder(habitat::parse_nav_mesh(bytes, name), kPublished)}));
}

std::string HabitatSceneFloor::file() const {
  return habitat::to_nav_mesh_file(impl_->finder.mesh());
}

std::size_t HabitatSceneFloor::islands() const noexcept { return impl_->finder.islands(); }

std::optional<int> HabitatSceneFloor::island_of(std::span<const Vec3f> points) const {
  std::vector<std::size_t> on(islands());
  for (const Vec3f point : points) {
    const int island = impl_->finder.island(to_habitat(point));
    if (island >= 0) ++on[static_cast<std::size_t>(island)];
  }
  const auto most = std::ranges::max_element(on);
  if (most == on.end() || *most == 0) return std::nullopt;
  return static_cast<int>(most - on.begin());
}

std::optional<Vec3f> HabitatSceneFloor::nearest(Vec3f point, int island, Reach reach) const {
  EN_CHECK(island >= 0 && static_cast<std::size_t>(island) < islands());
  const Vec3f found = from_habitat(impl_->finder.snap(to_habitat(point), island));
  const bool near = std::hypot(found.x - point.x, found.y - point.y) <= reach.aside &&
                    std::abs(found.z - point.z) <= reach.above_below;
  return near ? std::optional(found) : std::nullopt;  // NaN is not near
}

double HabitatSceneFloor::distance(Vec3f start, Vec3f end) const {
  return impl_->finder.path(to_habitat(start), to_habitat(end)).length;
}

std::optional<NearestGoal> HabitatSceneFloor::nearest_goal(Vec3f start,
                                                           std::span<const Vec3f> goals) const {
  std::vector<Vec3f> there;
  there.reserve(goals.size());
  for (const Vec3f goal : goals) there.push_back(to_habitat(goal));
  habitat::GoalBounds bounds;
  const habitat::GoalPath found = impl_->finder.path(to_habitat(start), there, bounds);
  if (found.goal < 0) return std::nullopt;
  return NearestGoal{static_cast<std::size_t>(found.goal), found.path.length};
}

std::vector<std::array<Vec3f, 3>> HabitatSceneFloor::triangles(int island) const {
  EN_CHECK(island >= 0 && static_cast<std::size_t>(island) < islands());
  return habitat::world_triangles(impl_->finder, island);
}

}  // namespace enfilade::continuous
