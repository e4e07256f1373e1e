#include "enfilade/continuous/habitat_scene_floor.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "enfilade/continuous/simulator.h"
#include "enfilade/core/errors.h"
#include "enfilade/geometry/vec.h"
#include "tests/support/made_meshes.h"

namespace enfilade::continuous {
namespace EN_UNIT {

// Two levels of 6 m x 4 m and 3 m x 3 m, that no body gets between: one at 0, one at 5 m.
mesh::Mesh two_levels() {
  return mesh::testing::Maker().level(0, 0, 6, 4, 0).level(20, 0, 23, 3, 5).mesh;
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

constexpr float kCell = 0.2F;  // metres that Habitat rounds heights up by, at most

TEST(HabitatSceneFloor, LiesWhereTheMeshIs) {
  const HabitatSceneFloor floor =
      HabitatSceneFloor::of_mesh(two_levels(), mesh::UpAxis::kZ, kRoomToRoomBody);
  ASSERT_EQ(floor.islands(), 2U);
  const std::array points{Vec3f{3, 2, 0.1F}, Vec3f{21, 1, 5}, Vec3f{1, 1, 0}, Vec3f{90, 90, 0}};
  const std::optional<int> main = floor.island_of(points);
  ASSERT_TRUE(main.has_value());
  const auto on = floor.nearest({3, 2, 0}, *main, {0.01F, kCell});
  ASSERT_TRUE(on.has_value());
  EXPECT_EQ(on->x, 3);
  EXPECT_EQ(on->y, 2);
  EXPECT_FALSE(floor.nearest({21, 1, 5}, *main, {0.5F, 1}).has_value());
  EXPECT_FALSE(floor.nearest({3, 2, 1.5F}, *main, {0.5F, 1}).has_value());  // too far above
  EXPECT_FALSE(floor.island_of(std::array{Vec3f{90, 90, 0}}).has_value());
}

TEST(HabitatSceneFloor, PathsAreStraightWhereNothingIsInTheWay) {
  const HabitatSceneFloor floor =
      HabitatSceneFloor::of_mesh(two_levels(), mesh::UpAxis::kZ, kRoomToRoomBody);
  EXPECT_NEAR(floor.distance({1, 1, 0}, {4, 1, 0}), 3, 1e-5);
  EXPECT_EQ(floor.distance({1, 1, 0}, {21, 1, 5}), std::numeric_limits<double>::infinity());
  const std::array goals{Vec3f{21, 1, 5}, Vec3f{4, 1, 0}, Vec3f{2, 1, 0}};
  const auto nearest = floor.nearest_goal({1, 1, 0}, goals);
  ASSERT_TRUE(nearest.has_value());
  EXPECT_EQ(nearest->goal, 2U);
  EXPECT_NEAR(nearest->distance, 1, 1e-5);
  EXPECT_FALSE(floor.nearest_goal({1, 1, 0}, std::array{goals[0]}).has_value());
}

TEST(HabitatSceneFloor, TrianglesCoverAnIsland) {
  const HabitatSceneFloor floor =
      HabitatSceneFloor::of_mesh(two_levels(), mesh::UpAxis::kZ, kRoomToRoomBody);
  double area = 0;
  const int main = floor.island_of(std::array{Vec3f{3, 2, 0}}).value();
  for (const auto& [a, b, c] : floor.triangles(main)) {
    area += length(cross(to_double(b - a), to_double(c - a))) / 2;
  }
  // Without a rim of the body's radius and a cell.
  EXPECT_NEAR(area, (6 - 2 * 0.15) * (4 - 2 * 0.15), 1);
}

TEST(HabitatSceneFloor, ItsFileGivesTheSameFloor) {
  const HabitatSceneFloor floor = HabitatSceneFloor::of_mesh(
      two_levels(), mesh::UpAxis::kZ, {.radius = 0.2, .height = 1, .step = 0.2, .slope = 45});
  const std::string file = floor.file();
  const HabitatSceneFloor again = HabitatSceneFloor::of_file(bytes_of(file), "a.navmesh");
  EXPECT_EQ(again.file(), file);
  EXPECT_EQ(again.islands(), 2U);
  EXPECT_THROW(HabitatSceneFloor::of_file(bytes_of("no mesh"), "a.navmesh"), InvalidInput);
  EXPECT_THROW(HabitatSceneFloor::of_mesh({}, mesh::UpAxis::kZ, kRoomToRoomBody), InvalidInput);
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous
