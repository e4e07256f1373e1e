#include "enfilade/agents/topological_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "enfilade/core/rng.h"
#include "tests/support/graphs.h"

namespace enfilade::agents {
namespace EN_UNIT {

using ::testing::ElementsAre;
using Node = TopologicalMap::Node;

ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

// The neighbours of a viewpoint as candidates; a map looks at nothing else of them.
std::vector<sim::Candidate> candidates(const graph::NavGraph& graph, ViewpointIndex here) {
  std::vector<sim::Candidate> found;
  for (const graph::Edge& edge : graph.edges(here)) {
    found.emplace_back().viewpoint = edge.target;
  }
  return found;
}

void arrive(TopologicalMap& map, const graph::NavGraph& graph, std::size_t here,
            std::uint32_t step) {
  map.arrive(graph, v(here), candidates(graph, v(here)), step);
}

std::vector<ViewpointIndex> path(const TopologicalMap& map, Node a, Node b) {
  std::vector<ViewpointIndex> out;
  map.path(a, b, out);
  return out;
}

TEST(TopologicalMap, NodesAreInTheOrderOfFirstSight) {
  const graph::NavGraph square(graph::testing::square());
  TopologicalMap map;
  arrive(map, square, 1, 0);  // sees 0 and 2
  ASSERT_EQ(map.size(), 3U);
  EXPECT_EQ(map.viewpoint(0), v(1));
  EXPECT_EQ(map.viewpoint(1), v(0));
  EXPECT_EQ(map.viewpoint(2), v(2));
  EXPECT_EQ(map.open(), 2U);
  EXPECT_THAT(map.rows(), ElementsAre(0U, 1U, 2U));
  arrive(map, square, 2, 1);  // sees 1 and 3
  EXPECT_EQ(map.viewpoint(3), v(3));
  EXPECT_THAT(map.rows(), ElementsAre(0U, 2U, 1U, 3U));  // visited first
  EXPECT_THAT(map.visits(), ElementsAre(0U, 2U));
  EXPECT_EQ(map.step_id(0), 1U);
  EXPECT_EQ(map.step_id(2), 2U);
  EXPECT_EQ(map.step_id(3), 0U);
  EXPECT_EQ(map.find(v(3)), 3U);
  map.clear();
  EXPECT_EQ(map.size(), 0U);
  EXPECT_EQ(map.find(v(1)), std::nullopt);
}

TEST(TopologicalMap, KnownPathsRunThroughVisitedNodesOnly) {
  const graph::NavGraph square(graph::testing::square());
  TopologicalMap map;
  arrive(map, square, 0, 0);                // nodes: 0, 1, 3
  EXPECT_DOUBLE_EQ(map.distance(1, 2), 4);  // v1 to v3, by way of v0
  EXPECT_THAT(path(map, 1, 2), ElementsAre(v(0), v(3)));
  EXPECT_EQ(map.hops(1, 2), 2U);
  arrive(map, square, 1, 1);  // sees v2, node 3
  EXPECT_DOUBLE_EQ(map.distance(0, 3), 4);
  // v3 to v2 is 2 m in the building, but nobody has been at either.
  EXPECT_DOUBLE_EQ(map.distance(2, 3), 6);
  EXPECT_THAT(path(map, 2, 3), ElementsAre(v(0), v(1), v(2)));
  arrive(map, square, 2, 2);
  EXPECT_DOUBLE_EQ(map.distance(2, 3), 2);
  EXPECT_THAT(path(map, 2, 3), ElementsAre(v(2)));
  EXPECT_DOUBLE_EQ(map.distance(3, 3), 0);
  EXPECT_TRUE(path(map, 3, 3).empty());
}

TEST(TopologicalMap, ArrivingAgainChangesNothingButTheStep) {
  const graph::NavGraph square(graph::testing::square());
  TopologicalMap map;
  arrive(map, square, 0, 0);
  arrive(map, square, 0, 4);
  EXPECT_EQ(map.size(), 3U);
  EXPECT_THAT(map.visits(), ElementsAre(0U));
  EXPECT_EQ(map.step_id(0), 5U);
}

// Against shortest paths over all edges of visited nodes, all found again after each step.
TEST(TopologicalMap, DistancesAreThoseOfAPlainSearch) {
  Rng rng(7);
  for (int round = 0; round < 20; ++round) {
    std::vector<Vec3d> points;
    std::vector<std::pair<int, int>> edges;
    constexpr int kPoints = 14;
    for (int i = 0; i < kPoints; ++i) {
      points.push_back({10 * rng.uniform(), 10 * rng.uniform(), 1.5});
      if (i > 0) edges.emplace_back(i, static_cast<int>(rng.below(static_cast<std::uint64_t>(i))));
      if (i > 2) edges.emplace_back(i, static_cast<int>(rng.below(static_cast<std::uint64_t>(i))));
    }
    const graph::NavGraph graph(graph::testing::connectivity("made", points, edges));
    TopologicalMap map;
    arrive(map, graph, 0, 0);
    for (std::uint32_t step = 1; map.open() > 0; ++step) {
      const Node next = map.rows()[map.visits().size() + rng.below(map.open())];
      arrive(map, graph, map.viewpoint(next).at(), step);
      const std::size_t n = map.size();
      std::vector<double> plain(n * n, std::numeric_limits<double>::infinity());
      for (Node a = 0; a < n; ++a) {
        plain[a * n + a] = 0;
        for (const graph::Edge& edge : graph.edges(map.viewpoint(a))) {
          const auto b = map.find(edge.target);
          if (!b || (!map.visited(a) && !map.visited(*b))) continue;
          plain[a * n + *b] = edge.length;
        }
      }
      for (Node k = 0; k < n; ++k) {
        if (!map.visited(k)) continue;  // nobody knows a way on from there
        for (Node a = 0; a < n; ++a) {
          for (Node b = 0; b < n; ++b) {
            plain[a * n + b] = std::min(plain[a * n + b], plain[a * n + k] + plain[k * n + b]);
          }
        }
      }
      for (Node a = 0; a < n; ++a) {
        for (Node b = 0; b < n; ++b) {
          // Single-precision positions: 1e-6 of 10 m, a dozen edges.
          ASSERT_NEAR(map.distance(a, b), plain[a * n + b], 1e-4) << round << " " << a << " " << b;
          double length = 0;
          ViewpointIndex from = map.viewpoint(a);
          for (const ViewpointIndex to : path(map, a, b)) {
            ASSERT_NE(graph.edge(from, to), nullptr);
            length += graph.edge(from, to)->length;
            from = to;
          }
          ASSERT_NEAR(length, map.distance(a, b), 1e-4);
          ASSERT_EQ(from, map.viewpoint(b));
        }
      }
    }
  }
}

TEST(MapFeature, IsDirectionAndDistancesFromTheAgent) {
  const graph::NavGraph square(graph::testing::square());
  TopologicalMap map;
  arrive(map, square, 0, 0);  // v1 lies east, v3 north, 2 m away
  // Single precision of pi / 2: cosines are 4e-8 from 0.
  const auto near = [](const MapFeature& feature, const MapFeature& wanted) {
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      EXPECT_NEAR(feature[i], wanted[i], 1e-7) << i;
    }
  };
  const float metres = 2.0F / 30;
  near(map_feature(map, 0, 1, Radians(0), Radians(0)), {1, 0, 0, 1, metres, metres, 0.1F});
  near(map_feature(map, 0, 1, degrees(90), Radians(0)), {0, 1, 0, 1, metres, metres, 0.1F});
  near(map_feature(map, 0, 2, Radians(0), degrees(30)),
       {0, 1, -0.5F, std::sqrt(0.75F), metres, metres, 0.1F});
  // From v1 to v3: south-west is 225 degrees, so north-west is 315; two viewpoints on the way.
  near(map_feature(map, 1, 2, Radians(0), Radians(0)),
       {-std::sqrt(0.5F), std::sqrt(0.5F), 0, 1, std::sqrt(8.0F) / 30, 4.0F / 30, 0.2F});
  // Its own place is not that of [stop].
  near(map_feature(map, 0, 0, degrees(90), Radians(0)), {-1, 0, 0, 1, 1e-8F / 30, 0, 0});
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
