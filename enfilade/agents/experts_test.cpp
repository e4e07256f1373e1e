#include "enfilade/agents/experts.h"

#include <gtest/gtest.h>

#include <vector>

#include "enfilade/core/errors.h"
#include "tests/support/graphs.h"

namespace enfilade::agents {
namespace EN_UNIT {

ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

// A corridor v0 v1 v2 v3, 2 m apart, and a long way round from v0 to v3 by v4.
graph::NavGraph corridor() {
  return graph::NavGraph(graph::testing::connectivity(
      "corridor", {{0, 0, 1.5}, {2, 0, 1.5}, {4, 0, 1.5}, {6, 0, 1.5}, {3, 6, 1.5}},
      {{0, 1}, {1, 2}, {2, 3}, {0, 4}, {4, 3}}));
}

void arrive(TopologicalMap& map, const graph::NavGraph& graph, std::size_t here,
            std::uint32_t step) {
  std::vector<sim::Candidate> found;
  for (const graph::Edge& edge : graph.edges(v(here))) {
    found.emplace_back().viewpoint = edge.target;
  }
  map.arrive(graph, v(here), found, step);
}

TEST(Experts, TheNextViewpointIsOnTheShortestPath) {
  const graph::NavGraph graph = corridor();
  EXPECT_EQ(next_on_shortest(graph, v(0), v(3)), v(1));
  EXPECT_EQ(next_on_shortest(graph, v(3), v(3)), v(3));
  const graph::NavGraph apart(
      graph::testing::connectivity("apart", {{0, 0, 1.5}, {2, 0, 1.5}}, {}));
  EXPECT_EQ(next_on_shortest(apart, v(0), v(1)), std::nullopt);
}

TEST(Experts, SplGoesTheShortestWayAndNdtwTheAnnotatedOne) {
  const graph::NavGraph graph = corridor();
  TopologicalMap map;
  arrive(map, graph, 0, 0);  // open: v1 and v4
  const std::vector<ViewpointIndex> walked{v(0)}, round{v(0), v(4), v(3)};
  EXPECT_EQ(map_expert({graph, map, walked, round}, ExpertRule::kSpl), v(1));
  EXPECT_EQ(map_expert({graph, map, walked, round}, ExpertRule::kNdtw), v(4));
}

TEST(Experts, StopOnTheGoalAndNothingWhereNothingIsOpen) {
  const graph::NavGraph graph = corridor();
  TopologicalMap map;
  arrive(map, graph, 0, 0);
  const std::vector<ViewpointIndex> walked{v(0)}, here{v(0)};
  EXPECT_EQ(map_expert({graph, map, walked, here}, ExpertRule::kSpl), v(0));
  const std::vector<ViewpointIndex> all{v(0), v(1), v(2), v(3), v(4)};
  for (std::uint32_t i = 1; i < 5; ++i) arrive(map, graph, i, i);
  EXPECT_EQ(map_expert({graph, map, all, here}, ExpertRule::kSpl), std::nullopt);
}

TEST(Experts, RulesHaveNames) {
  EXPECT_EQ(parse_expert_rule("spl"), ExpertRule::kSpl);
  EXPECT_EQ(parse_expert_rule("ndtw"), ExpertRule::kNdtw);
  EXPECT_THROW(parse_expert_rule("cls"), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
