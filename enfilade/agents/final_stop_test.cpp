#include "enfilade/agents/topological_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/support/graphs.h"

namespace enfilade::agents {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

// A corridor v0 v1 v2 that has been walked from v0 to v2; nodes are numbered alike.
TopologicalMap walked() {
  const graph::NavGraph graph(graph::testing::connectivity(
      "corridor", {{0, 0, 1.5}, {2, 0, 1.5}, {4, 0, 1.5}}, {{0, 1}, {1, 2}}));
  TopologicalMap map;
  for (std::uint32_t i = 0; i < 3; ++i) {
    std::vector<sim::Candidate> found;
    for (const graph::Edge& edge : graph.edges(v(i))) {
      found.emplace_back().viewpoint = edge.target;
    }
    map.arrive(graph, v(i), found, i);
  }
  return map;
}

std::vector<ViewpointIndex> walk(const StopMemory& memory, LastAction last, FinalStop rule) {
  std::vector<ViewpointIndex> out{v(2)};
  final_walk(walked(), 2, memory, last, rule, out);
  return out;
}

TEST(FinalStop, GoesBackToWhereStoppingWasMostProbable) {
  StopMemory memory;
  memory.remember(0, 0.5);
  memory.remember(1, 0.1);
  memory.remember(2, 0.4);
  EXPECT_THAT(walk(memory, LastAction::kLimit, FinalStop::kAlways), ElementsAre(v(1), v(0)));
  EXPECT_THAT(walk(memory, LastAction::kStop, FinalStop::kAlways), ElementsAre(v(1), v(0)));
  EXPECT_THAT(walk(memory, LastAction::kNothingOpen, FinalStop::kUnlessOwn),
              ElementsAre(v(1), v(0)));
  EXPECT_THAT(walk(memory, LastAction::kStop, FinalStop::kUnlessOwn), IsEmpty());
}

TEST(FinalStop, TheFirstOfEqualsIsTakenAndALaterVisitReplaces) {
  StopMemory memory;
  EXPECT_EQ(memory.best(), std::nullopt);
  EXPECT_THAT(walk(memory, LastAction::kLimit, FinalStop::kAlways), IsEmpty());
  memory.remember(1, 0.4);
  memory.remember(0, 0.4);
  EXPECT_EQ(memory.best(), 1U);
  memory.remember(1, 0.2);
  EXPECT_EQ(memory.best(), 0U);
  memory.remember(2, 0.9);
  EXPECT_THAT(walk(memory, LastAction::kLimit, FinalStop::kAlways), IsEmpty());
  memory.clear();
  EXPECT_EQ(memory.best(), std::nullopt);
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
