#include "enfilade/graph/nav_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <thread>

#include "enfilade/core/rng.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"
#include "tests/support/graphs.h"

namespace enfilade::graph {
namespace EN_UNIT {

using ::testing::ElementsAre;

constexpr ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

TEST(NavGraph, EdgesHaveHeadingElevationAndDistance) {
  const NavGraph graph(
      testing::connectivity("s", {{0, 0, 0}, {3, 0, 0}, {0, -2, 2}}, {{0, 1}, {0, 2}}));
  ASSERT_EQ(graph.edges(v(0)).size(), 2U);
  const Edge& right = graph.edges(v(0))[0];
  EXPECT_EQ(right.target, v(1));
  EXPECT_NEAR(to_degrees(right.heading), 90, 1e-12);  // +x is to the right of +y
  EXPECT_EQ(right.elevation.value, 0);
  EXPECT_EQ(right.distance, 3.0F);
  const Edge& back = graph.edges(v(0))[1];
  EXPECT_NEAR(to_degrees(back.heading), 180, 1e-12);
  EXPECT_NEAR(to_degrees(back.elevation), 45, 1e-12);
  EXPECT_DOUBLE_EQ(back.length, std::sqrt(8.0));
  EXPECT_EQ(graph.edge(v(1), v(2)), nullptr);
  EXPECT_EQ(graph.max_degree(), 2U);
}

TEST(NavGraph, ExcludedViewpointsKeepTheirIndexAndHaveNoEdges) {
  scan::Connectivity c = testing::square();
  c.entries[1].included = false;
  const NavGraph graph(c);
  EXPECT_EQ(graph.size(), 4U);
  EXPECT_EQ(graph.included_count(), 3U);
  EXPECT_TRUE(graph.edges(v(1)).empty());
  EXPECT_EQ(graph.edge(v(0), v(1)), nullptr);
  EXPECT_EQ(graph.find("v3"), v(3));
  EXPECT_EQ(graph.distance(v(0), v(2)), 4);
  EXPECT_EQ(graph.distance(v(0), v(1)), std::numeric_limits<double>::infinity());
  EXPECT_EQ(graph.path(v(0), v(1)), std::nullopt);
  EXPECT_EQ(graph.find("v4"), std::nullopt);
}

TEST(NavGraph, OneWayEdgesStayOneWay) {
  scan::Connectivity c = testing::square();
  c.entries[0].unobstructed = {v(1)};
  const NavGraph graph(c);
  EXPECT_EQ(graph.distance(v(3), v(0)), 2);
  EXPECT_EQ(graph.distance(v(0), v(3)), 6);
}

TEST(NavGraph, EqualPathsGoByTheLowerIndex) {
  const NavGraph graph(testing::square());
  EXPECT_THAT(graph.path(v(0), v(2)).value(), ElementsAre(v(0), v(1), v(2)));
  EXPECT_THAT(graph.path(v(1), v(3)).value(), ElementsAre(v(1), v(0), v(3)));
  EXPECT_THAT(graph.path(v(2), v(2)).value(), ElementsAre(v(2)));
  EXPECT_EQ(graph.before(v(2), v(2)), std::nullopt);
}

TEST(NavGraph, NearestIsTheNearestIncludedOne) {
  scan::Connectivity c = testing::square();
  EXPECT_EQ(NavGraph(c).nearest({1.9F, 0.3F, 0}), v(1));
  EXPECT_EQ(NavGraph(c).nearest({1, 1, 1.5F}), v(0)) << "a tie goes to the lower index";
  c.entries[1].included = false;
  EXPECT_EQ(NavGraph(c).nearest({1.9F, 0.3F, 0}), v(2));
  EXPECT_EQ(NavGraph(c).nearest({0, std::numeric_limits<float>::quiet_NaN(), 0}), std::nullopt);
  EXPECT_EQ(NavGraph(scan::Connectivity{}).nearest({0, 0, 0}), std::nullopt);
}

TEST(NavGraph, NearestAgreesWithLookingAtAll) {
  Rng rng(1);
  std::vector<Vec3d> points;
  for (int i = 0; i < 300; ++i) {
    points.push_back({rng.uniform() * 20, rng.uniform() * 20, 3.0 * double(rng.below(3))});
  }
  const NavGraph graph(testing::connectivity("s", points, {}));
  for (int i = 0; i < 1000; ++i) {
    const Vec3f q{static_cast<float>(rng.uniform() * 22 - 1),
                  static_cast<float>(rng.uniform() * 22 - 1), static_cast<float>(rng.below(7))};
    std::size_t best = 0;
    for (std::size_t k = 1; k < points.size(); ++k) {
      if (length(graph.position(v(k)) - q) < length(graph.position(v(best)) - q)) best = k;
    }
    ASSERT_EQ(graph.nearest(q), v(best));
  }
}

TEST(NavGraph, ManyThreadsMayAskFirst) {
  const NavGraph graph(testing::square());
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&graph] {
      EXPECT_EQ(graph.distance(v(0), v(2)), 4);
      EXPECT_EQ(graph.nearest({2, 2, 1.5F}), v(2));
    });
  }
}

TEST(NavGraph, RealGraphsHaveThePapersNumbers) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real graphs";
  const auto graphs = GraphSet::open(data->connectivity());
  graphs->load_all();
  std::size_t viewpoints = 0;
  std::size_t edges = 0;
  for (std::size_t i = 0; i < graphs->size(); ++i) {
    const NavGraph& graph = graphs->graph(ScanIndex(i));
    viewpoints += graph.included_count();
    edges += graph.edge_count();
  }
  // The paper: 117 viewpoints a graph, average degree 4.1.
  EXPECT_NEAR(double(viewpoints) / double(graphs->size()), 117.4, 0.05);
  EXPECT_NEAR(double(edges) / double(viewpoints), 4.06, 0.005);
}

}  // namespace EN_UNIT
}  // namespace enfilade::graph
