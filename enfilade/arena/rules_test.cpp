#include "enfilade/arena/world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/run.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/metrics.h"
#include "tests/support/grid_world.h"
#include "tests/support/refusal.h"
#include "tests/support/room_world.h"

namespace enfilade::arena {
namespace EN_UNIT {

using arena::testing::episodes;
using ::testing::HasSubstr;

tasks::Trajectory walk(GraphWorld& world, std::size_t episode, Rule rule, std::uint64_t seed = 1) {
  const auto session = world.start_on_graph(episode);
  const auto follower = world.follow(rule, *session, seed);
  while (!session->ending()) EXPECT_TRUE(session->call(follower()));
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
    const auto walked = agents::run_agent(*agent, *world.episodes().on_graph(), {.seed = seed});
    for (std::size_t e = 0; e < walked.size(); ++e) {
      EXPECT_EQ(places(walk(world, e, Rule::kRandom, seed)), places(walked[e])) << e;
    }
  }
}

TEST(Rules, TheOracleSucceedsOnTheShortestWay) {
  GraphWorld world(episodes(tasks::Task::kR2r, 20));
  for (std::size_t e = 0; e < world.size(); ++e) {
    const auto& all = *world.episodes().on_graph();
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

TEST(Rules, TheOracleSaysWhereItTurnsBack) {
  GraphWorld world(episodes(tasks::Task::kR2rBack));
  const tasks::Trajectory walked = walk(world, 0, Rule::kOracle);
  EXPECT_EQ(walked.turning_point, ViewpointIndex(4));
  const std::vector<std::uint32_t> way = places(walked);  // by v1 or v3: both are as short
  ASSERT_EQ(way.size(), 5U);
  EXPECT_EQ(way[2], 4U);
  EXPECT_EQ(way[4], 0U);
}

std::vector<std::uint8_t> actions(FloorWorld& world, std::size_t episode, Rule rule,
                                  std::uint64_t seed = 1) {
  const auto session = world.start(episode, usual_limits(world.task()));
  const auto follower = world.follow(rule, *session, seed);
  while (!session->ending()) EXPECT_TRUE(session->call(follower()));
  return std::get<tasks::ContinuousResult>(session->walked()).actions;
}

TEST(Rules, MoveOnTheFloorAsTheAgentsDo) {
  const agents::ContinuousSetup& setup = agents::continuous_setup("r2r-ce");
  FloorWorld world = testing::room(6);
  for (const auto& [rule, name] :
       {std::pair{Rule::kOracle, "shortest"}, {Rule::kRandom, "random"}}) {
    const auto agent = agents::make_continuous_agent(name);
    const auto walks =
        agents::run_continuous(*agent, *world.episodes().continuous(), world.buildings(),
                               {.seed = 3, .simulator = setup.simulator});
    for (std::size_t e = 0; e < walks.size(); ++e) {
      EXPECT_EQ(actions(world, e, rule, 3), walks[e].actions) << name << e;
    }
  }
  EXPECT_EQ(actions(world, 0, Rule::kStop).size(), 1U);
  EXPECT_EQ(actions(world, 0, Rule::kFirst).size(), 125U) << "a call is one step forward";
}

TEST(Rules, OthersStopOrNeverDo) {
  GraphWorld world(episodes());
  EXPECT_EQ(walk(world, 0, Rule::kStop).points.size(), 1U);
  const auto session = world.start_on_graph(0);
  const auto follower = world.follow(Rule::kFirst, *session);
  while (!session->ending()) session->call(follower());
  EXPECT_EQ(session->ending(), Ending::kOutOfSteps);
  EXPECT_THAT(tests::refusal<LookupError>([] { rule_named("second"); }),
              HasSubstr("no rule \"second\"; there are first, random, oracle, stop"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
