#include "enfilade/homes/small_building.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "enfilade/core/rng.h"
#include "enfilade/graph/check.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::homes {
namespace {

using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::UnorderedElementsAre;

constexpr std::uint64_t kSeeds = 40;

std::map<std::string, std::set<std::string>> neighbouring_rooms(const SmallBuilding& building) {
  std::vector<std::string> name(building.connectivity.entries.size());
  for (const Room& room : building.rooms) {
    for (const ViewpointIndex v : room.viewpoints) name[v.at()] = room.name;
  }
  std::map<std::string, std::set<std::string>> neighbours;
  for (std::size_t i = 0; i < name.size(); ++i) {
    for (const ViewpointIndex v : building.connectivity.entries[i].unobstructed) {
      if (name[v.at()] != name[i]) neighbours[name[i]].insert(name[v.at()]);
    }
  }
  return neighbours;
}

TEST(SmallBuilding, HasNothingOddAboutIt) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto diagnostics = graph::check_graph(make_small_building(seed, "synth").connectivity);
    EXPECT_TRUE(diagnostics.empty()) << "seed " << seed << ": " << to_string(diagnostics.front());
  }
}

TEST(SmallBuilding, IsOfTheSizeAndSpacingOfASmallHouse) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const graph::NavGraph graph(make_small_building(seed, "synth").connectivity);
    EXPECT_GE(graph.size(), 35U);
    EXPECT_LE(graph.size(), 50U);
    const double n = static_cast<double>(graph.size());
    EXPECT_NEAR(static_cast<double>(graph.edge_count()) / n, 4, 1) << "mean degree";
    double sum = 0;  // of the distances to the nearest other viewpoint
    for (std::size_t i = 0; i < graph.size(); ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const graph::Edge& edge : graph.edges(ViewpointIndex(i))) {
        nearest = std::min(nearest, edge.length);
      }
      EXPECT_GE(nearest, 1.2) << i;
      EXPECT_LE(nearest, 3.0) << i;
      sum += nearest;
    }
    EXPECT_NEAR(sum / n, 2.0, 0.25) << "mean separation";
  }
}

TEST(SmallBuilding, KeepsToDoorsAndStairs) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const SmallBuilding building = make_small_building(seed, "synth");
    auto rooms = neighbouring_rooms(building);
    // Beside the stairs nothing but the hallway has a door to these.
    EXPECT_THAT(rooms["entryway"], UnorderedElementsAre("hallway"));
    EXPECT_THAT(rooms["bathroom"], UnorderedElementsAre("upstairs hallway"));
    EXPECT_THAT(rooms["stairs"], UnorderedElementsAre("hallway", "upstairs hallway"));
    EXPECT_EQ(rooms["hallway"].size(), 6U) << "four rooms, the entryway, the stairs";
    EXPECT_EQ(rooms["upstairs hallway"].size(), 6U);
    for (const auto& [name, neighbours] : rooms) {
      EXPECT_LE(neighbours.size(), 6U) << name;
      EXPECT_FALSE(neighbours.contains("hallway") && neighbours.contains("upstairs hallway") &&
                   name != "stairs")
          << name << " is on one storey";
    }
  }
}

TEST(SmallBuilding, PutsEachViewpointInOneRoomAndLeadsFromRoomToRoom) {
  const SmallBuilding building = make_small_building(3, "synth");
  const graph::NavGraph graph(building.connectivity);
  std::multiset<ViewpointIndex> seen;
  std::set<std::string> names;
  for (const Room& room : building.rooms) {
    EXPECT_THAT(room.viewpoints, ::testing::Not(IsEmpty())) << room.name;
    EXPECT_TRUE(names.insert(room.name).second) << room.name;
    seen.insert(room.viewpoints.begin(), room.viewpoints.end());
    for (const Room& other : building.rooms) {
      EXPECT_TRUE(graph.path(room.viewpoints.front(), other.viewpoints.back()))
          << room.name << " to " << other.name;
    }
  }
  EXPECT_EQ(seen.size(), graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) EXPECT_EQ(seen.count(ViewpointIndex(i)), 1U);
}

TEST(SmallBuilding, WritesPosesAndIdsLikeMatterport3D) {
  const SmallBuilding building = make_small_building(4, "synth");
  std::set<std::string> ids;
  for (const scan::ConnectivityEntry& e : building.connectivity.entries) {
    EXPECT_THAT(e.id, MatchesRegex("[0-9a-f]{32}"));
    EXPECT_TRUE(ids.insert(e.id).second);
    EXPECT_EQ(e.height, 1.5);
    const Vec3d down{e.pose[1], e.pose[5], e.pose[9]};
    EXPECT_EQ(down, (Vec3d{0, 0, -1})) << "the second column of a level camera";
    EXPECT_TRUE(std::ranges::includes(e.visible, e.unobstructed)) << "who can walk there sees it";
  }
}

TEST(SmallBuilding, IsTheSameForTheSameSeedOnEveryPlatform) {
  const std::string json = to_json(make_small_building(1, "synth").connectivity);
  EXPECT_EQ(json, to_json(make_small_building(1, "other name").connectivity));
  EXPECT_NE(json, to_json(make_small_building(2, "synth").connectivity));
  // Recorded with gcc 12 and glibc 2.36 on x86-64.
  EXPECT_EQ(stream_of(json.data(), json.size()), 8476675064871408664U);
  const auto again = scan::parse_connectivity(json, "synth", "<memory>");
  EXPECT_EQ(to_json(again), json);
}

}  // namespace
}  // namespace enfilade::homes
