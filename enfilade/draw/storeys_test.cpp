#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/draw/floor_plan.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"
#include "tests/support/graphs.h"

namespace enfilade::draw {
namespace EN_UNIT {

using graph::NavGraph;

// Viewpoints whose floors are at the given heights.
NavGraph with_floors(const std::vector<double>& floors) {
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < floors.size(); ++i) {
    points.push_back({static_cast<double>(i), 0, floors[i] + 1.5});
  }
  return NavGraph(graph::testing::connectivity("floors", points, {}));
}

std::vector<std::size_t> sizes(const std::vector<GraphStorey>& storeys) {
  std::vector<std::size_t> found;
  for (const GraphStorey& storey : storeys) found.push_back(storey.viewpoints.size());
  return found;
}

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(FindStoreys, FindsNoneInAnEmptyGraph) {
  EXPECT_THAT(find_storeys(NavGraph(scan::Connectivity{})), IsEmpty());
  EXPECT_THAT(sizes(find_storeys(with_floors({4}))), ElementsAre(1)) << "and one in a tiny one";
}

TEST(FindStoreys, SplitsByFloorAndPutsStairsWithTheNearest) {
  const auto storeys =
      find_storeys(with_floors({3.0, 0, 0.1, -0.1, 0, 3.1, 2.9, 3.0, /*stairs*/ 0.7, 1.4, 2.2}));
  ASSERT_THAT(sizes(storeys), ElementsAre(6, 5));
  EXPECT_NEAR(storeys[0].floor, 0.1, 0.1) << "the median, stairs included";
  EXPECT_NEAR(storeys[1].floor, 3.0, 0.1);
  EXPECT_EQ(storeys[1].viewpoints.front(), ViewpointIndex(0));
}

TEST(FindStoreys, KeepsStepsWithinOneStorey) {
  EXPECT_THAT(sizes(find_storeys(with_floors({0, 0, 0, 0, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0}))),
              ElementsAre(10));
}

TEST(FindStoreys, NeedsThreeViewpointsForAnotherStorey) {
  EXPECT_THAT(sizes(find_storeys(with_floors({0, 0, 0, 0, 3, 3}))), ElementsAre(6));
  EXPECT_THAT(sizes(find_storeys(with_floors({0, 0, 0, 0, 3, 3, 3}))), ElementsAre(4, 3));
  std::vector<double> large(200, 0.0);  // 3 % of 205 are 7
  large.insert(large.end(), 5, 3.0);
  EXPECT_THAT(sizes(find_storeys(with_floors(large))), ElementsAre(205));
}

TEST(FindStoreys, TakesStairsForNoStoreyHoweverManyStepsAreListed) {
  EXPECT_THAT(sizes(find_storeys(with_floors(
                  {0, 0, 0, 0, 4, 4, 4, 4, /*stairs*/ 1.0, 1.3, 1.7, 2.05, 2.4, 2.7, 3.0}))),
              ElementsAre(7, 8));
}

TEST(FindStoreys, LeavesExcludedViewpointsOut) {
  scan::Connectivity c = graph::testing::square();
  c.entries[2].included = false;
  EXPECT_THAT(sizes(find_storeys(NavGraph(c))), ElementsAre(3));
}

TEST(FindStoreys, UsesEachViewpointOfTheRealGraphsOnce) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real graphs";
  const auto graphs = graph::GraphSet::open(data->connectivity());
  for (std::size_t s = 0; s < graphs->size(); ++s) {
    const NavGraph& graph = graphs->graph(ScanIndex(s));
    SCOPED_TRACE(graph.scan());
    std::vector<int> seen(graph.size(), 0);
    const auto storeys = find_storeys(graph);
    for (std::size_t k = 0; k < storeys.size(); ++k) {
      for (const ViewpointIndex v : storeys[k].viewpoints) ++seen[v.at()];
      // Modes are 1.8 m apart; the viewpoints of stairs move the medians.
      if (k > 0) {
        EXPECT_GT(storeys[k].floor - storeys[k - 1].floor, 1.2);
      }
    }
    for (std::size_t i = 0; i < graph.size(); ++i) {
      EXPECT_EQ(seen[i], graph.included(ViewpointIndex(i)) ? 1 : 0) << i;
    }
  }
  // Counted by looking at the plans.
  EXPECT_EQ(find_storeys(graphs->graph("17DRP5sb8fy")).size(), 1U);
  EXPECT_EQ(find_storeys(graphs->graph("vyrNrziPKCB")).size(), 2U);
  EXPECT_EQ(find_storeys(graphs->graph("V2XKFyX4ASd")).size(), 4U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
