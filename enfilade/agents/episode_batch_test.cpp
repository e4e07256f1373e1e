#include "enfilade/agents/episode_batch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "enfilade/core/errors.h"
#include "tests/support/graphs.h"

namespace enfilade::agents {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// On a square of side 2 m: from corner 0 to corner 2 by way of 1, heading east; and a start at
// corner 1 whose goal is hidden.
tasks::EpisodeSet square_episodes() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square());
  tasks::EpisodeSet set;
  set.split = "made";
  set.graphs = graph::GraphSet::of(std::move(graphs));
  const auto v = [](std::size_t i) { return ViewpointIndex(i); };
  set.paths = {{0, ScanIndex(0), degrees(90), {v(0), v(1), v(2)}},
               {1, ScanIndex(0), Radians(0), {v(1)}}};
  set.episodes = {{"0_0", 0, 0, "walk"}, {"1_0", 1, 0, "walk"}};
  return set;
}

sim::SimulatorConfig two_agents() {
  auto config = sim::SimulatorConfig::room_to_room();
  config.navigation = sim::Navigation::kUnrestricted;
  config.batch_size = 2;
  return config;
}

constexpr std::array<std::size_t, 2> kBoth{0, 1};

TEST(EpisodeBatch, BeginsWhereThePathsBegin) {
  const tasks::EpisodeSet episodes = square_episodes();
  EpisodeBatch batch(episodes, two_agents());
  EXPECT_EQ(batch.running(), 0U);
  EXPECT_TRUE(batch.ended(0));
  batch.begin(kBoth);
  EXPECT_EQ(batch.running(), 2U);
  EXPECT_EQ(batch.state().viewpoint[0], ViewpointIndex(0));
  EXPECT_DOUBLE_EQ(batch.state().heading[0], degrees(90).value);
  EXPECT_EQ(batch.state().viewpoint[1], ViewpointIndex(1));
  EXPECT_DOUBLE_EQ(batch.distance_to_goal(0), 4);
  EXPECT_TRUE(std::isnan(batch.distance_to_goal(1)));
  ASSERT_EQ(batch.trajectory(0).points.size(), 1U);
  EXPECT_EQ(batch.trajectory(0).episode, 0U);
}

TEST(EpisodeBatch, RecordsWhatRunningSlotsDoAndNothingOfEndedOnes) {
  const tasks::EpisodeSet episodes = square_episodes();
  EpisodeBatch batch(episodes, two_agents());
  batch.begin(kBoth);
  batch.end(1);
  batch.end(1);  // twice is once
  EXPECT_EQ(batch.running(), 1U);
  const std::array<sim::Action, 2> actions{sim::Action{0, Radians(1), {}}, sim::Action{}};
  batch.step(actions);
  EXPECT_EQ(batch.trajectory(0).points.size(), 2U);
  EXPECT_NEAR(batch.trajectory(0).points[1].heading.value, degrees(120).value, 1e-9);
  EXPECT_EQ(batch.trajectory(1).points.size(), 1U);
  EXPECT_TRUE(batch.observation(1).ended);
  EXPECT_EQ(batch.observation(0).step, 1U);
}

TEST(EpisodeBatch, AWalkIsOneActionWithAPointForEachViewpoint) {
  const tasks::EpisodeSet episodes = square_episodes();
  EpisodeBatch batch(episodes, two_agents());
  batch.begin(kBoth);
  const std::array<ViewpointIndex, 2> path{ViewpointIndex(1), ViewpointIndex(2)};
  batch.walk(0, path, 15);  // level, to the east
  EXPECT_EQ(batch.state().viewpoint[0], ViewpointIndex(2));
  EXPECT_EQ(batch.state().view_index[0], 15U);
  EXPECT_EQ(batch.state().viewpoint[1], ViewpointIndex(1));
  ASSERT_EQ(batch.trajectory(0).points.size(), 3U);
  EXPECT_EQ(batch.trajectory(0).points[1].viewpoint, ViewpointIndex(1));
  EXPECT_NEAR(batch.trajectory(0).points[2].heading.value, degrees(90).value, 1e-12);
  EXPECT_EQ(batch.trajectory(0).actions, 1U);
  EXPECT_EQ(batch.trajectory(1).actions, std::nullopt);
  EXPECT_EQ(batch.observation(0).step, 1U);
  batch.step(std::vector<sim::Action>(2));
  EXPECT_EQ(batch.trajectory(0).actions, 2U);
  EXPECT_EQ(batch.observation(0).step, 2U);
  EXPECT_EQ(batch.observation(1).step, 1U);
  batch.walk(1, std::array{ViewpointIndex(1)}, 12);  // one that has taken a step before
  EXPECT_EQ(batch.trajectory(1).actions, 2U);
  batch.begin(0, 0);
  EXPECT_EQ(batch.trajectory(0).actions, std::nullopt);
}

TEST(EpisodeBatch, ASlotBeginsAnewWithoutTheOthers) {
  const tasks::EpisodeSet episodes = square_episodes();
  EpisodeBatch batch(episodes, two_agents(), 5);
  batch.begin(kBoth);
  batch.step(std::array<sim::Action, 2>{});
  batch.end(0);
  batch.begin(0, 1);
  EXPECT_EQ(batch.running(), 2U);
  EXPECT_EQ(batch.index(0), 1U);
  EXPECT_EQ(batch.trajectory(0).points.size(), 1U);
  EXPECT_EQ(batch.trajectory(1).points.size(), 2U);
  const std::vector<tasks::Trajectory> taken = batch.take_trajectories();
  EXPECT_EQ(taken[1].points.size(), 2U);
  EXPECT_EQ(batch.running(), 0U);
}

TEST(EpisodeBatch, ObservationsHaveTheNavigableRowOfTheirSlot) {
  const tasks::EpisodeSet episodes = square_episodes();
  EpisodeBatch batch(episodes, two_agents());
  batch.begin(kBoth);
  const Observation seen = batch.observation(1);
  ASSERT_EQ(seen.navigable.size(), 3U);  // itself and two corners
  EXPECT_EQ(seen.navigable.viewpoint[0], ViewpointIndex(1));
  EXPECT_EQ(seen.episode->instruction_id, "1_0");
  EXPECT_EQ(seen.reference.size(), 1U);
}

TEST(EpisodeBatch, RefusesEpisodesThatAreNotThere) {
  const tasks::EpisodeSet episodes = square_episodes();
  EpisodeBatch batch(episodes, two_agents());
  EXPECT_THAT([&] { batch.begin(0, 2); }, ThrowsMessage<ArgumentError>(HasSubstr("episode 2")));
  EXPECT_THAT([&] { batch.begin(std::array<std::size_t, 1>{0}); },
              ThrowsMessage<ArgumentError>(HasSubstr("1 episodes for a batch of 2")));
  EXPECT_EQ(batch.running(), 0U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
