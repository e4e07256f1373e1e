#include "enfilade/continuous/habitat/habitat_floor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "enfilade/continuous/buildings.h"
#include "enfilade/continuous/follower.h"
#include "enfilade/continuous/habitat/body.h"
#include "enfilade/continuous/simulator.h"
#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "enfilade/geometry/habitat_frame.h"
#include "tests/support/flat_floor.h"
#include "tests/support/made_meshes.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::continuous::habitat {
namespace EN_UNIT {

using testing::flat_triangles;

constexpr Reach kNear{1, 1};

// An L around the corner near the origin, and a room of 2 m apart.
NavMesh corner_mesh() {
  return make_nav_mesh(flat_triangles({{-3, -3, 0, 3}, {0, -3, 3, 0}, {5, -1, 7, 1}}),
                       settings_of(kRoomToRoomBody), Navigation::kV033);
}

std::shared_ptr<const HabitatFloor> corner_floor() {
  return std::make_shared<const HabitatFloor>(corner_mesh());
}

FloorPoint on(const Floor& floor, float x, float y) {
  return floor.nearest({x, y, 0}, kNear).value();
}

TEST(HabitatFloor, HasTheBodysSettingsAndHabitatsDefaults) {
  EXPECT_EQ(settings_of(kRoomToRoomBody), NavMeshSettings());
  const NavMeshSettings other = settings_of(kRoomAcrossRoomBody);
  EXPECT_FLOAT_EQ(other.agent_radius, 0.18F);
  EXPECT_FLOAT_EQ(other.agent_height, 0.88F);
  EXPECT_EQ(corner_floor()->settings(), NavMeshSettings());
}

TEST(HabitatFloor, PointsAreHabitatsAndKeepWhereTheyWereLookedFor) {
  const auto floor = corner_floor();
  const PathFinder finder(corner_mesh(), Navigation::kV033);
  const Vec3f beside{-3.5F, 1, 0.5F};
  const auto found = floor->nearest(beside, kNear);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->point, from_habitat(finder.snap(to_habitat(beside))));
  EXPECT_EQ(found->asked, beside);
  EXPECT_FALSE(floor->nearest(beside, {0.5F, 1}));
  EXPECT_FALSE(floor->nearest(beside, {1, 0.2F}));
  EXPECT_FALSE(floor->nearest({-9, 0, 0}, {20, 20}));  // Habitat looks no farther than 2 m
  EXPECT_FALSE(floor->nearest({std::numeric_limits<float>::quiet_NaN(), 0, 0}, kNear));
}

TEST(HabitatFloor, PartsAreIslands) {
  const auto floor = corner_floor();
  const PathFinder finder(corner_mesh(), Navigation::kV033);
  ASSERT_EQ(floor->areas(), 2U);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(floor->area_m2(k), finder.island_area(k));
  const std::size_t room = floor->area_of(on(*floor, 6, 0));
  EXPECT_NE(room, floor->area_of(on(*floor, -1, 1)));
  Rng rng(4);
  for (int k = 0; k < 200; ++k) {
    const FloorPoint drawn = floor->random_point(
        rng, k % 2 == 0 ? std::optional(static_cast<std::uint32_t>(room)) : std::nullopt);
    EXPECT_TRUE(finder.is_navigable(to_habitat(drawn.point)));
    if (k % 2 == 0) {
      EXPECT_GT(drawn.point.x, 5);
    }
  }
}

TEST(HabitatFloor, DistancesAndPathsAreHabitatsToTheBit) {
  const auto floor = corner_floor();
  const PathFinder finder(corner_mesh(), Navigation::kV033);
  Rng rng(5);
  std::vector<FloorPoint> points;
  for (int k = 0; k < 40; ++k) {
    const FloorPoint drawn = floor->random_point(rng, std::nullopt);
    points.push_back(*floor->nearest(drawn.point + Vec3f{0, 0, 0.3F}, kNear));  // off the floor
  }
  for (std::size_t k = 1; k < points.size(); ++k) {
    const FloorPoint &a = points[k - 1], &b = points[k];
    const Path path = finder.path(to_habitat(a.asked), to_habitat(b.asked));
    EXPECT_EQ(floor->distance(a, b), path.length);
    EXPECT_EQ(floor->field(b).distance(a), path.length);
    const auto found = floor->path(a, b);
    ASSERT_EQ(found.has_value(), path.found());
    if (!found) continue;
    ASSERT_EQ(found->size(), path.points.size());
    for (std::size_t p = 0; p < found->size(); ++p) {
      EXPECT_EQ((*found)[p], from_habitat(path.points[p]));
    }
  }
}

TEST(HabitatFloor, AFieldLeadsToTheNearestGoal) {
  const auto floor = corner_floor();
  const std::vector<FloorPoint> goals{on(*floor, 6, 0), on(*floor, -2, -2), on(*floor, 2, 2)};
  const DistanceField field = floor->field(goals);
  const FloorPoint start = on(*floor, -1, -1);
  EXPECT_EQ(field.distance(start), floor->distance(start, goals[1]));
  const auto way = field.way(on(*floor, 1.5F, 2));
  ASSERT_TRUE(way);
  EXPECT_NEAR(way->next.x, 2, 1e-5);
  // Round the corner: the first straight line ends there.
  const auto around = floor->field(on(*floor, -2, -2)).way(on(*floor, 2, 2));
  ASSERT_TRUE(around);
  EXPECT_NEAR(around->next.x, 0, 0.4);
  EXPECT_NEAR(around->next.y, 0, 0.4);
  EXPECT_FALSE(floor->field(on(*floor, 6, 0)).way(start));
  EXPECT_TRUE(std::isinf(floor->distance(start, goals[0])));
  EXPECT_THROW(static_cast<void>(floor->field(std::span<const FloorPoint>())), ArgumentError);
}

// A body of Habitat's turns in float32, so its direction differs in the last bits.
TEST(HabitatFloor, StepsOfTheSimulatorAreHabitats) {
  for (const bool slides : {true, false}) {
    const auto floor = corner_floor();
    const PathFinder finder(corner_mesh(), Navigation::kV033);
    const Ground ground{&finder, slides ? Moves::kSlide : Moves::kStop};
    SimulatorConfig config;
    config.walls = slides ? Walls::kSlide : Walls::kStop;
    config.most_steps = 2000;
    Simulator simulator(std::make_shared<const Buildings>(std::vector<Building>{{"corner", floor}}),
                        config);
    const Vec3f start = on(*floor, -1, -1).point;
    simulator.new_episode(0, {.building = 0, .pose = {start, {}, {}}});
    habitat::Pose body{to_habitat(start), {}};
    Rng rng(6);
    std::size_t collided = 0;
    for (int k = 0; k < 1000; ++k) {
      const auto action = static_cast<Action>(1 + rng.below(3));
      simulator.step(std::span(&action, 1));
      const bool forward = action == Action::kForward;
      const Motion motion = forward                   ? Motion::kMoveForward
                            : action == Action::kLeft ? Motion::kTurnLeft
                                                      : Motion::kTurnRight;
      const bool stopped = act(body, motion, forward ? 0.25F : 15, ground);
      const Vec3f apart = from_habitat(body.position) - simulator.state().position[0];
      ASSERT_LT(length(apart), 1e-3) << "step " << k;
      if (forward) {
        ASSERT_EQ(simulator.state().collided[0] != 0, stopped) << "step " << k;
      }
      collided += simulator.state().collided[0];
      body.position = to_habitat(simulator.state().position[0]);  // errors do not add up
    }
    EXPECT_GT(collided, 50U);
  }
}

TEST(HabitatFloor, ExpertsWalkAround) {
  const auto floor = corner_floor();
  const SimulatorConfig config;
  Simulator simulator(std::make_shared<const Buildings>(std::vector<Building>{{"corner", floor}}),
                      config);
  const FloorPoint goal = on(*floor, -2, -2);
  simulator.new_episode(0, {.building = 0, .pose = {{2, 2, 0}, degrees(77), {}}});
  EXPECT_GT(simulator.state().off_floor[0], 0);
  ReferenceFollower expert(floor, {goal}, config);
  while (simulator.state().episode[0] == EpisodeState::kWalking) {
    const Action action =
        expert.next(simulator.floor_point(0), Radians(simulator.state().heading[0]));
    simulator.step(std::span(&action, 1));
  }
  EXPECT_EQ(simulator.state().episode[0], EpisodeState::kStopped);
  EXPECT_LT(floor->distance(simulator.floor_point(0), goal), 0.5);
}

TEST(HabitatFloor, AnswersAreTheSameInAnyThread) {
  const auto floor = corner_floor();
  Rng rng(7);
  std::vector<FloorPoint> points;
  for (int k = 0; k < 400; ++k) points.push_back(floor->random_point(rng, std::nullopt));
  const FloorPoint goal = on(*floor, -2, -2);
  std::vector<double> alone, together(points.size());
  for (const FloorPoint& point : points) alone.push_back(floor->distance(point, goal));
  parallel_for(points.size(), 1, 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) together[k] = floor->distance(points[k], goal);
  });
  EXPECT_EQ(together, alone);
}

TEST(HabitatFloor, OutlinesHaveTheFloorsArea) {
  const auto floor = corner_floor();
  const mesh::FloorPolygons& outlines = floor->polygons();
  EXPECT_NEAR(outlines.body.radius, 0.1, 1e-6);
  const auto corner = [&](std::uint16_t c) {
    return Vec3d{outlines.low.x + outlines.cell * outlines.corners.at(c)[0],
                 outlines.low.y + outlines.cell * outlines.corners.at(c)[1], 0};
  };
  std::vector<double> areas(floor->areas(), 0);
  for (std::size_t p = 0; p < outlines.polygons.size(); ++p) {
    const mesh::FloorPolygon& polygon = outlines.polygons[p];
    double twice = 0;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Vec3d a = corner(polygon.corners[k]);
      const Vec3d b = corner(polygon.corners[(k + 1) % polygon.size()]);
      twice += a.x * b.y - a.y * b.x;
      EXPECT_TRUE(floor->nearest(to_float(a), {0.01F, 1}));
      const std::uint16_t beyond = polygon.beyond[k];
      if (beyond == mesh::FloorPolygon::kNone) continue;
      EXPECT_THAT(outlines.polygons.at(beyond).beyond,
                  ::testing::Contains(static_cast<std::uint16_t>(p)));
    }
    areas.at(polygon.area) += std::abs(twice) / 2;
  }
  for (std::size_t k = 0; k < areas.size(); ++k) EXPECT_NEAR(areas[k], floor->area_m2(k), 1e-3);
}

TEST(HabitatFloor, BuildingsTellByTheFile) {
  const tests::TemporaryFolder folder("habitat-floor");
  write_file_atomically(folder.path() / "corner.navmesh", to_nav_mesh_file(corner_mesh()));
  const Buildings buildings(folder.path());
  EXPECT_EQ(buildings.floor_name(), "habitat 0.3.3");
  EXPECT_EQ(buildings.floor(0).kind(), FloorKind::kHabitat);
  EXPECT_EQ(buildings.floor(0).areas(), 2U);
  const mesh::RayTracer tracer(
      std::make_shared<const mesh::Mesh>(mesh::testing::Maker().room(0, 0, 5, 4).mesh));
  const mesh::FloorPolygons ours = make_floor_polygons(tracer);
  save_navigation_mesh(ours, folder.path() / "room.navmesh");
  try {
    const Buildings mixed(folder.path());
    FAIL() << "two floors in one folder";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.diagnostics().front().code, "mixed-floors");
    EXPECT_THAT(error.diagnostics().front().file, ::testing::EndsWith("room.navmesh"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("corner.navmesh"));
  }
  EXPECT_THROW(Buildings(std::vector<Building>{{"corner", corner_floor()},
                                               {"room", std::make_shared<NavigationMesh>(ours)}}),
               ArgumentError);
}

TEST(HabitatFloor, DamagedFilesAreRefusedAtTheirFirstUse) {
  const tests::TemporaryFolder folder("habitat-floor");
  std::string bytes = to_nav_mesh_file(corner_mesh());
  bytes.resize(bytes.size() / 2);
  write_file_atomically(folder.path() / "corner.navmesh", bytes);
  const Buildings buildings(folder.path());
  try {
    static_cast<void>(buildings.floor(0));
    FAIL() << "half a file";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.diagnostics().front().code, "truncated");
    EXPECT_THAT(error.diagnostics().front().file, ::testing::EndsWith("corner.navmesh"));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous::habitat
