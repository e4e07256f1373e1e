#include "enfilade/arena/rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "enfilade/agents/run.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/metrics.h"
#include "tests/support/grid_world.h"
#include "tests/support/refusal.h"

namespace enfilade::arena {
namespace {

using arena::testing::episodes;
using ::testing::HasSubstr;

tasks::Trajectory walk(GraphWorld& world, std::size_t episode, Rule rule, std::uint64_t seed = 1) {
  const auto session = start_session(world, episode);
  const auto follower = follow(rule, world, *session, seed);
  while (!session->ending()) EXPECT_TRUE(session->call(follower->next()));
  return std::get<tasks::Trajectory>(session->walked());
}

/// Viewpoints, one after another, without turns on the spot.
std::vector<std::uint32_t> places(const tasks::Trajectory& trajectory) {
  std::vector<std::uint32_t> all;
  for (const auto& point : trajectory.points) {
    if (all.empty() || all.back() != point.viewpoint.value) all.push_back(point.viewpoint.value);
  }
  return all;
}

TEST(Rules, RandomWalksAsTheAgentDoes) {
  GraphWorld world(episodes(tasks::Task::kR2r, 40));
  for (const std::uint64_t seed : {1U, 2U}) {
    const auto agent = agents::make_agent("random");
    const auto walked = agents::run_agent(*agent, world.episodes(), {.seed = seed});
    for (std::size_t e = 0; e < walked.size(); ++e) {
      EXPECT_EQ(places(walk(world, e, Rule::kRandom, seed)), places(walked[e])) << e;
    }
  }
}

TEST(Rules, TheOracleSucceedsOnTheShortestWay) {
  GraphWorld world(episodes(tasks::Task::kR2r, 20));
  for (std::size_t e = 0; e < world.episodes().episodes.size(); ++e) {
    const auto& all = world.episodes();
    std::vector<ViewpointIndex> walked;
    for (const std::uint32_t v : places(walk(world, e, Rule::kOracle))) walked.emplace_back(v);
    const auto metrics = tasks::compute_metrics(all.graph_of(all.episodes[e]), walked,
                                                all.path_of(all.episodes[e]).viewpoints);
    EXPECT_EQ(metrics.success, 1) << e;
    EXPECT_NEAR(metrics.spl, 1, 1e-12) << e;
  }
}

TEST(Rules, TheOracleNamesTheObject) {
  GraphWorld world(episodes(tasks::Task::kReverie));
  const tasks::Trajectory walked = walk(world, 0, Rule::kOracle);
  EXPECT_EQ(walked.object, "7");
  EXPECT_EQ(walked.points.back().viewpoint.value, 1U);
}

TEST(Rules, OthersStopOrNeverDo) {
  GraphWorld world(episodes());
  EXPECT_EQ(walk(world, 0, Rule::kStop).points.size(), 1U);
  const auto session = start_session(world, 0);
  const auto follower = follow(Rule::kFirst, world, *session);
  while (!session->ending()) session->call(follower->next());
  EXPECT_EQ(session->ending(), Ending::kOutOfSteps);
  EXPECT_THAT(tests::refusal<LookupError>([] { rule_named("second"); }),
              HasSubstr("no rule \"second\"; there are first, random, oracle, stop"));
}

}  // namespace
}  // namespace enfilade::arena
