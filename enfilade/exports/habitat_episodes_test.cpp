#include "enfilade/exports/habitat_episodes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "enfilade/continuous/simulator.h"
#include "enfilade/exports/habitat_objects.h"
#include "enfilade/mesh/ray_tracer.h"
#include "tests/support/furnished_room.h"
#include "tests/support/made_meshes.h"

namespace enfilade::exports {
namespace EN_UNIT {

using Json = nlohmann::json;
using continuous::HabitatSceneFloor;

HabitatSceneFloor floor_of(const mesh::Mesh& mesh,
                           const mesh::Body& body = continuous::kRoomToRoomBody) {
  return HabitatSceneFloor::of_mesh(mesh, mesh::UpAxis::kZ, body);
}

// Two furnished rooms, and their floors to Habitat.
struct Rooms {
  std::shared_ptr<const mesh::Mesh> mesh =
      std::make_shared<const mesh::Mesh>(tests::furnished_rooms());
  mesh::RayTracer tracer{mesh};
  scan::Connectivity connectivity = tests::furnished_room_graph();
  graph::NavGraph graph{connectivity};
  HabitatIsland island = habitat_island(floor_of(*mesh), graph).value();
  HabitatIsland own = habitat_island(floor_of(*mesh, kObjectNavBody), graph).value();
  mesh::House house = make_house_files(*mesh, connectivity, tests::furnished_room_list()).house;

  ObjectGoalScene objects(const HabitatDraws& draws = {}) const {
    return draw_object_goals("rooms", island, own, tracer, house, draws);
  }
};
const Rooms& rooms() {
  static const Rooms kRooms;
  return kRooms;
}

bool is_on(const HabitatIsland& island, Vec3f point) {
  return island.floor.nearest(point, island.island, {.aside = 1e-3F, .above_below = 0.25F})
      .has_value();
}
bool is_inside(Vec3f p) { return p.x > 0 && p.x < 7.5F && p.y > 0 && p.y < 5 && p.z < 0.3F; }

TEST(HabitatIsland, IsWhereTheViewpointsStand) {
  EXPECT_TRUE(is_on(rooms().island, {2.3F, 2.6F, 0}));
  EXPECT_FALSE(is_on(rooms().island, {2.3F, 2.6F, 2.7F})) << "the roof";
  const mesh::Mesh elsewhere = mesh::testing::Maker().level(50, 50, 60, 60, 0).mesh;
  EXPECT_FALSE(habitat_island(floor_of(elsewhere), rooms().graph).has_value());
}

TEST(PointGoals, AreOnTheFloorAndCanBeReached) {
  const auto episodes = draw_point_goals("rooms", rooms().island, {40, 3});
  ASSERT_EQ(episodes.size(), 40U);
  std::size_t winding = 0;
  for (const PointGoalEpisode& e : episodes) {
    for (const Vec3f point : {e.start, e.goal}) {
      EXPECT_TRUE(is_on(rooms().island, point));
      EXPECT_TRUE(is_inside(point));
    }
    EXPECT_EQ(e.geodesic_distance, rooms().island.floor.distance(e.start, e.goal));
    EXPECT_GE(e.geodesic_distance, 1);
    EXPECT_LE(e.geodesic_distance, 30);
    winding += e.geodesic_distance > 1.1 * length(to_double(e.goal - e.start)) ? 1U : 0U;
  }
  EXPECT_GT(winding, 4U) << "straight ones are seldom taken";
}

TEST(PointGoals, DependOnSeedAndSceneAlone) {
  const auto text = [](const std::string& scan, std::size_t count, std::uint64_t seed) {
    return point_goals_json(draw_point_goals(scan, rooms().island, {count, seed}));
  };
  EXPECT_EQ(text("rooms", 5, 1), text("rooms", 5, 1));
  EXPECT_NE(text("rooms", 5, 1), text("rooms", 5, 2));
  EXPECT_NE(text("rooms", 5, 1), text("other", 5, 1));
  EXPECT_EQ(Json::parse(text("rooms", 0, 1))["episodes"], Json::array());
}

TEST(PointGoals, FilesAreInHabitatsFrame) {
  PointGoalEpisode episode{
      "home0001", {1, 2, 0.5F}, {4, 2, 0.25F}, tasks::StartRotation::of(degrees(90)), 3};
  const Json json = Json::parse(point_goals_json(std::array{episode}))["episodes"][0];
  EXPECT_EQ(json["episode_id"], "0");
  EXPECT_EQ(json["scene_id"], "mp3d/home0001/home0001.glb");
  EXPECT_EQ(json["start_position"], (Json{1, 0.5, -2}));
  EXPECT_EQ(json["goals"][0]["position"], (Json{4, 0.25, -2}));
  EXPECT_EQ(json["goals"][0]["radius"], 0.2);
  EXPECT_EQ(json["info"]["geodesic_distance"], 3);
  const auto turned = json["start_rotation"].get<std::vector<double>>();
  EXPECT_NEAR(turned[1], -std::sqrt(0.5), 1e-12);  // to the right: clockwise from above
  EXPECT_NEAR(turned[3], std::sqrt(0.5), 1e-12);
}

TEST(ObjectGoals, AreObjectsOfTheTasksCategoriesThatAreInView) {
  const ObjectGoalScene scene = rooms().objects({0, 1});
  std::map<std::string, std::string> found;
  for (const ObjectGoal& goal : scene.goals) found[goal.name] = goal.category;
  const std::map<std::string, std::string> wanted{{"coffee table", "table"},
                                                  {"sofa", "sofa"},
                                                  {"picture", "picture"},
                                                  {"bed", "bed"},
                                                  {"wardrobe", "cabinet"}};
  EXPECT_EQ(found, wanted) << "no wall, column or lamp";
  for (const ObjectGoal& goal : scene.goals) {
    ASSERT_FALSE(goal.views.empty());
    double before = 1;
    for (const ObjectView& view : goal.views) {
      EXPECT_TRUE(is_on(rooms().island, view.at) && is_on(rooms().own, view.at)) << goal.name;
      EXPECT_TRUE(is_inside(view.at));
      EXPECT_LE(view.iou, before);
      EXPECT_GE(view.iou, 0.05);
      before = view.iou;
      const Vec3f to = goal.middle - view.at;
      const double off = view.rotation.heading().value - std::atan2(to.x, to.y);
      EXPECT_NEAR(std::cos(off), 1, 1e-9) << goal.name;
    }
  }
}

TEST(ObjectGoals, AreNotSeenThroughWalls) {
  const ObjectGoalScene scene = rooms().objects({0, 1});
  for (const ObjectGoal& goal : scene.goals) {
    if (goal.name != "wardrobe") continue;  // against the wall between the rooms
    for (const ObjectView& view : goal.views) EXPECT_GT(view.at.x, 4.1F);
  }
}

TEST(ObjectGoals, EpisodesBeginOnTheFloorAndEndAtTheNearestView) {
  const ObjectGoalScene scene = rooms().objects({30, 5});
  ASSERT_EQ(scene.episodes.size(), 30U);
  std::set<std::string> categories;
  for (const ObjectGoalEpisode& e : scene.episodes) {
    EXPECT_TRUE(is_on(rooms().island, e.start) && is_on(rooms().own, e.start));
    EXPECT_TRUE(is_inside(e.start));
    categories.insert(e.category);
    double nearest = INFINITY;
    std::string closest;
    for (const ObjectGoal& goal : scene.goals) {
      if (goal.category != e.category) continue;
      if (goal.object == e.closest) closest = goal.category;
      for (const ObjectView& view : goal.views) {
        nearest = std::min(nearest, rooms().own.floor.distance(e.start, view.at));
      }
    }
    EXPECT_NEAR(e.geodesic_distance, nearest, 0.03);  // Habitat's search is not exact
    EXPECT_LE(e.euclidean_distance, e.geodesic_distance + 1e-5);
    EXPECT_EQ(closest, e.category);
  }
  EXPECT_EQ(categories.size(), 5U);
}

TEST(ObjectGoals, FilesHaveGoalsBySceneAndCategory) {
  const ObjectGoalScene scene = rooms().objects({3, 5});
  ObjectGoalScene other = scene;
  other.scan = "other";
  const Json json = Json::parse(object_goals_json(std::array{scene, other}));
  EXPECT_TRUE(json["goals_by_category"].contains("other.glb_bed"));
  EXPECT_EQ(json["episodes"].size(), 6U);
  EXPECT_EQ(json["episodes"][5]["episode_id"], "5");
  EXPECT_EQ(json["category_to_task_category_id"]["chair"], 0);
  EXPECT_EQ(json["category_to_task_category_id"]["clothes"], 20);
  EXPECT_EQ(json["category_to_mp3d_category_id"]["clothes"], 38);
  EXPECT_EQ(json["category_to_mp3d_category_id"].size(), 21U);
  const Json& sofa = json["goals_by_category"]["rooms.glb_sofa"][0];
  EXPECT_EQ(sofa["object_category"], "sofa");
  EXPECT_EQ(sofa["view_points"][0]["agent_state"]["rotation"].size(), 4U);
  const std::string none = object_goals_json({});
  EXPECT_EQ(Json::parse(none)["goals_by_category"], Json::object());
}

}  // namespace EN_UNIT
}  // namespace enfilade::exports
