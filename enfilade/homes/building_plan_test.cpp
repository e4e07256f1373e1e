#include "enfilade/homes/building_plan.h"

#include <gmock/gmock.h>
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/mesh/house.h"
#include "enfilade/scan/connectivity.h"
#include "tests/support/panoramas.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::homes {
namespace EN_UNIT {

namespace fs = std::filesystem;
using draw::UnderlayLine;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using tests::TemporaryFolder;

std::size_t count(const BuildingPlan& plan, UnderlayLine::Kind kind) {
  std::size_t found = 0;
  for (const auto& storey : plan.underlay.storeys) {
    found += static_cast<std::size_t>(std::ranges::count(storey.lines, kind, &UnderlayLine::kind));
  }
  return found;
}

/// A small flat without pictures.
class PlanOfAHome : public ::testing::Test {
 protected:
  PlanOfAHome() {
    HomeSetOptions options = home_set_preset("small");
    options.homes = 1;
    options.face_size = 0;
    home_ = write_homes(folder_.path(), options).homes.front();
  }
  graph::NavGraph graph() const {
    return graph::NavGraph(scan::load_connectivity(folder_.path() / "connectivity", home_.scan));
  }
  BuildingPlan plan() const { return read_building_plan(folder_.path(), {}, graph()); }

  const TemporaryFolder folder_{"building_plan"};
  HomeEntry home_;
};

TEST_F(PlanOfAHome, HasTheListsLinesAndTheNamesOfItsRooms) {
  const BuildingPlan made = plan();
  ASSERT_EQ(made.rooms.size(), home_.rooms.size());
  ASSERT_EQ(made.underlay.storeys.size(), 1U);
  EXPECT_EQ(made.underlay.storeys[0].texts.size(), home_.rooms.size());
  for (const UnderlayLine::Kind kind : {UnderlayLine::Kind::kWall, UnderlayLine::Kind::kDoor,
                                        UnderlayLine::Kind::kWindow, UnderlayLine::Kind::kThing}) {
    EXPECT_GT(count(made, kind), 0U);
  }
  for (std::size_t r = 0; r < made.rooms.size(); ++r) {
    EXPECT_EQ(made.rooms[r].name, home_.rooms[r].name);
    EXPECT_EQ(made.rooms[r].viewpoints.size(), home_.rooms[r].viewpoints.size());
    EXPECT_EQ(made.rooms[r].outline.size(), 4U);
  }
  draw::FloorPlanOptions options;
  options.underlay = made.drawn();
  ASSERT_NE(options.underlay, nullptr);
  const std::string svg = draw::floor_plan_svg(graph(), {}, options);
  for (const char* text : {">wall<", ">door<", ">window<", ">furniture<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  EXPECT_THAT(svg, HasSubstr(">" + home_.rooms.front().name + "<"));
}

TEST_F(PlanOfAHome, IsMadeAgainWhereTheListLacksTheLines) {
  const BuildingPlan before = plan();
  const fs::path list = folder_.path() / "homes.json";
  auto old = nlohmann::ordered_json::parse(read_file(list));
  for (auto& home : old.at("homes")) home.erase("lines");
  write_file_atomically(list, old.dump());
  const BuildingPlan after = plan();
  for (const auto& [name, kind] : draw::kUnderlayKinds) {
    EXPECT_EQ(draw::line_ends(after.underlay.storeys[0].lines, kind),
              draw::line_ends(before.underlay.storeys[0].lines, kind))
        << name;
  }
}

TEST(PlanOfABuilding, IsEmptyWhereNothingIsKnown) {
  const TemporaryFolder folder("building_plan");
  const graph::NavGraph row(scan::testing::row_of_viewpoints("row", 4));
  const BuildingPlan plan =
      read_building_plan(folder.path(), std::vector<fs::path>{folder.path()}, row);
  EXPECT_TRUE(plan.rooms.empty());
  EXPECT_EQ(plan.underlay.storeys.size(), 1U) << "one for each of the graph";
  EXPECT_EQ(plan.drawn(), nullptr);
}

TEST(PlanOfABuilding, OfAScannedOneIsItsHouseFile) {
  const TemporaryFolder folder("building_plan");
  mesh::House house;
  house.name = "row";
  house.levels.push_back({"-", {}, {{-1, -2, 0}, {9, 2, 3}}});
  house.regions.push_back({0, 'k', {}, {{-1, -2, 0}, {6, 2, 2.5}}, 2.5});
  house.panoramas.push_back({"v1", 0, {1, 0, 1.5}});
  house.categories.push_back({0, "table", 5, "table"});
  house.categories.push_back({1, "picture", 6, "picture"});
  for (const int category : {0, 1}) {
    house.objects.push_back({0, category, {3, 1, 0.4}, {0, 1, 0}, {-1, 0, 0}, {0.8, 0.5, 0.4}});
  }
  const fs::path images = folder.path() / "v1/scans";
  make_folder(images / "row/house_segmentations");
  write_file_atomically(images / "row/house_segmentations/row.house", mesh::to_text(house));
  const graph::NavGraph row(scan::testing::row_of_viewpoints("row", 4));
  const BuildingPlan plan =
      read_building_plan(folder.path(), std::vector{folder.path(), images}, row);
  ASSERT_EQ(plan.rooms.size(), 1U);
  EXPECT_EQ(plan.rooms[0].name, "kitchen");
  EXPECT_EQ(plan.rooms[0].height, 2.5);
  EXPECT_THAT(plan.rooms[0].viewpoints, ElementsAre(ViewpointIndex(1)));
  EXPECT_EQ(count(plan, UnderlayLine::Kind::kWall), 4U);
  EXPECT_EQ(count(plan, UnderlayLine::Kind::kThing), 4U) << "a picture is no furniture";
  ASSERT_EQ(plan.underlay.storeys[0].texts.size(), 1U);
  EXPECT_EQ(plan.underlay.storeys[0].texts[0].text, "kitchen");
  EXPECT_NEAR(plan.underlay.storeys[0].texts[0].at.x, 2.5, 1e-6) << "its middle";
}

// What stands or hangs above half a storey is still on its own floor.
TEST(PlanOfABuilding, ObjectsAreOnTheStoreyOfTheirRoom) {
  const TemporaryFolder folder("building_plan");
  scan::Connectivity graph = scan::testing::row_of_viewpoints("row", 8);
  for (std::size_t v = 4; v < 8; ++v) graph.entries[v].pose[11] = 4.5;  // floors at 0 and 3 m
  mesh::House house;
  house.name = "row";
  house.levels.push_back({"-", {}, {{-1, -2, 0}, {9, 2, 6}}});
  house.regions.push_back({0, 'k', {}, {{-1, -2, 0}, {4, 2, 2.7}}, 2.7});
  house.categories.push_back({0, "cabinet", 7, "cabinet"});
  house.categories.push_back({1, "wardrobe", 7, "cabinet"});
  house.categories.push_back({2, "window", 9, "window"});
  house.objects.push_back({0, 0, {1, 1, 2}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.2, 0.4}});
  house.objects.push_back({-1, 1, {2, 1, 1.6}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.3, 0.9}});
  house.objects.push_back({-1, 2, {6, 1, 4.6}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.1, 0.6}});
  make_folder(folder.path() / "row/house_segmentations");
  write_file_atomically(folder.path() / "row/house_segmentations/row.house", mesh::to_text(house));
  const BuildingPlan plan = read_building_plan(folder.path(), std::vector<fs::path>{folder.path()},
                                               graph::NavGraph(std::move(graph)));
  ASSERT_EQ(plan.underlay.storeys.size(), 2U);
  const auto on = [&plan](std::size_t storey, UnderlayLine::Kind kind) {
    return std::ranges::count(plan.underlay.storeys[storey].lines, kind, &UnderlayLine::kind);
  };
  EXPECT_EQ(on(0, UnderlayLine::Kind::kThing), 8) << "one hangs in a room, one is of no room";
  EXPECT_EQ(on(1, UnderlayLine::Kind::kThing), 0);
  EXPECT_EQ(on(0, UnderlayLine::Kind::kWindow), 0);
  EXPECT_EQ(on(1, UnderlayLine::Kind::kWindow), 4);
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes
