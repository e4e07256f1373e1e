#include "enfilade/tasks/path_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/path_sampling.h"
#include "tests/support/graphs.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

// Two squares of side 2 m; in "a", v0 and v1 are in room 0, v2 in room 1, v3 in none.
std::shared_ptr<const graph::GraphSet> squares() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square("a"));
  graphs.emplace_back(graph::testing::square("b"));
  return graph::GraphSet::of(std::move(graphs));
}

scan::RegionMap rooms() {
  return scan::RegionMap::parse(R"({"a":{"0":["v0","v1"],"1":["v2"]}})", "rooms.json");
}

PathAnnotation path(const char* scan, std::vector<std::string> viewpoints) {
  return {0, scan, Radians(0), std::move(viewpoints), std::nullopt, {}};
}

TEST(ComparePaths, FactsByHand) {
  const Annotations drawn{"drawn",
                          "drawn",
                          {path("a", {"v0", "v1", "v2"}),        // between rooms
                           path("a", {"v1", "v2"}),              // the same rooms
                           path("a", {"v2", "v3", "v0"}),        // v1 of that room is as near as
                           path("a", {"v2", "v3", "v0", "v1"}),  // not shortest; the same rooms
                           path("a", {"v0", "v1"}),              // in one room
                           path("a", {"v0", "v3"}),              // v3 is in none
                           path("b", {"v0", "v1"}),              // nor is b
                           path("b", {"v0"})}};                  // hidden
  const std::vector<Annotations> reference{{"val", "val.json", {path("a", {"v0", "v1"})}}};
  const PathComparison c = compare_paths(drawn, reference, *squares(), rooms());
  EXPECT_EQ(c.drawn.paths, 7U);
  EXPECT_EQ(c.drawn.buildings, 2U);
  EXPECT_EQ(c.drawn.most_in_a_building, 6U);
  EXPECT_EQ(c.drawn.buildings_with_most, 1U);
  EXPECT_EQ(c.drawn.not_shortest, 1U);
  EXPECT_EQ(c.drawn.between_rooms, 4U);
  EXPECT_EQ(c.drawn.repeated_pairs, 2U);
  EXPECT_EQ(c.drawn.to_nearest, 3U) << "v1 is nearer to v2 than v0 is";
  EXPECT_EQ(c.drawn.in_one_room, 1U);
  EXPECT_EQ(c.drawn.outside_map, 2U);
  EXPECT_THAT(c.drawn.edges, ElementsAre(Pair(1, 4), Pair(2, 2), Pair(3, 1)));
  EXPECT_THAT(c.drawn.metres, ElementsAre(Pair(1, 4), Pair(2, 2), Pair(3, 1)));
  EXPECT_EQ(c.drawn_there.paths, 6U);
  EXPECT_EQ(c.reference.paths, 1U);
  EXPECT_NEAR(c.all.edges.statistic, 3.0 / 7, 1e-12);    // rounding of one quotient
  EXPECT_NEAR(c.there.edges.statistic, 3.0 / 6, 1e-12);  // likewise
  EXPECT_EQ(c.all.length.statistic, c.all.edges.statistic) << "all edges are 2 m long";
  EXPECT_FALSE(c.between_rooms) << "the reference has none";
  const auto self = compare_paths(drawn, {{drawn}}, *squares(), rooms());
  ASSERT_TRUE(self.between_rooms);
  EXPECT_EQ(self.between_rooms->edges.statistic, 0);
}

TEST(ComparePaths, TableShowsBothSides) {
  const std::vector<Annotations> sets{{"val", "val.json", {path("a", {"v0", "v1"})}}};
  const std::string table = to_table(compare_paths(sets[0], sets, *squares(), rooms()));
  EXPECT_THAT(table, HasSubstr("  1 edge                                   100.0 %"));
  EXPECT_THAT(table, HasSubstr("  2 to 4 m                                 100.0 %"));
  EXPECT_THAT(table,
              HasSubstr("drawn : data set                            0.0000               1"));
}

TEST(ComparePaths, NeedsABuildingInCommon) {
  const Annotations a{"a", "a.json", {path("a", {"v0", "v1"})}};
  const std::vector<Annotations> b{{"b", "b.json", {path("b", {"v0", "v1"})}}};
  EXPECT_THROW(compare_paths(a, b, *squares(), rooms()), ArgumentError);
  EXPECT_THROW(compare_paths(a, {}, *squares(), rooms()), ArgumentError);
}

// The evidence of docs/sampling.md, and how near its rule comes.
TEST(ComparePaths, DrawnPathsAreNearRoomToRoom) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real paths";
  const auto graphs = graph::GraphSet::open(data->connectivity());
  const auto regions = scan::RegionMap::load(data->regions());
  std::vector<Annotations> reference;
  for (const char* split : {"train", "val_seen", "val_unseen"}) {
    reference.push_back(load_annotations(data->annotations(split), split));
  }
  const auto compare = [&](PairRule rule) {
    SamplingOptions options;
    options.pairs = rule;
    const Annotations drawn{"drawn", "drawn", sample_paths(*graphs, regions, options)};
    return compare_paths(drawn, reference, *graphs, regions);
  };
  const PathComparison rooms = compare(PairRule::kRooms);
  EXPECT_EQ(rooms.reference.paths, 5798U);
  EXPECT_EQ(rooms.reference.most_in_a_building, 100U);
  EXPECT_EQ(rooms.reference.repeated_pairs, 0U) << "of 4,683";
  EXPECT_EQ(rooms.reference.between_rooms, 4683U);
  // 0.03 and 0.035 on average over seeds (docs/sampling.md); draws vary by about 0.01.
  EXPECT_LT(rooms.all.length.statistic, 0.05);
  EXPECT_LT(rooms.all.edges.statistic, 0.05);
  ASSERT_TRUE(rooms.between_rooms);
  EXPECT_LT(rooms.between_rooms->edges.statistic, 0.03);
  const PathComparison viewpoints = compare(PairRule::kViewpoints);
  EXPECT_GT(viewpoints.all.length.statistic, 0.07) << "the rule matters";
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
