#include "enfilade/agents/batch_environment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "enfilade/core/errors.h"
#include "tests/support/graphs.h"

namespace enfilade::agents {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// One path on a square of side 2 m from corner 0, heading north, to corner 2, and one to corner 1.
std::shared_ptr<const tasks::EpisodeSet> square_episodes() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square());
  auto set = std::make_shared<tasks::EpisodeSet>();
  set->split = "made";
  set->graphs = graph::GraphSet::of(std::move(graphs));
  const auto v = [](std::size_t i) { return ViewpointIndex(i); };
  set->paths = {{0, ScanIndex(0), Radians(0), {v(0), v(1), v(2)}},
                {1, ScanIndex(0), Radians(0), {v(0), v(1)}}};
  set->episodes = {{"0_0", 0, 0, "walk"}, {"1_0", 1, 0, "walk"}};
  return set;
}

EnvironmentConfig config(std::size_t batch, ActionSpace actions, Reward reward) {
  EnvironmentConfig c;
  c.batch_size = batch;
  c.actions = actions;
  c.reward = reward;
  c.success_distance = 1;
  return c;
}

// The place of a viewpoint in an agent's navigable list.
std::int64_t entry(const BatchEnvironment& environment, std::size_t agent, std::size_t viewpoint) {
  const std::size_t row = agent * environment.config().max_navigable;
  for (std::uint32_t k = 0; k < environment.state().navigable_count[agent]; ++k) {
    if (environment.state().navigable_viewpoint[row + k].at() == viewpoint) return k;
  }
  return -1;
}

TEST(BatchEnvironment, WalksToTheGoalAndPaysForProgress) {
  BatchEnvironment environment(square_episodes(),
                               config(1, ActionSpace::kViewpoint, Reward::kProgress));
  environment.reset({}, std::array<std::int64_t, 1>{0});
  const Outcome& out = environment.outcome();
  EXPECT_DOUBLE_EQ(out.distance[0], 4);
  environment.step(std::array{entry(environment, 0, 1)});
  EXPECT_DOUBLE_EQ(out.reward[0], 2);
  EXPECT_NEAR(environment.state().heading[0], kPi / 2, 1e-6);  // it looks where it went: east
  environment.step(std::array{entry(environment, 0, 2)});
  EXPECT_DOUBLE_EQ(out.reward[0], 2);
  EXPECT_EQ(out.terminated[0], 0);
  environment.step(std::array<std::int64_t, 1>{0});
  EXPECT_DOUBLE_EQ(out.reward[0], 2);
  EXPECT_EQ(out.terminated[0], 1);
  EXPECT_DOUBLE_EQ(out.success[0], 1);
  EXPECT_DOUBLE_EQ(out.spl[0], 1);
  EXPECT_DOUBLE_EQ(environment.compute_metrics(0).ndtw, 1);
}

TEST(BatchEnvironment, AWrongStopCostsAndAnImpossibleMoveIsNone) {
  BatchEnvironment environment(square_episodes(),
                               config(1, ActionSpace::kViewpoint, Reward::kProgress));
  environment.reset({}, std::array<std::int64_t, 1>{0});
  environment.step(std::array<std::int64_t, 1>{15});  // it has two neighbours
  EXPECT_EQ(environment.state().viewpoint[0], ViewpointIndex(0));
  EXPECT_DOUBLE_EQ(environment.outcome().reward[0], 0);
  environment.step(std::array<std::int64_t, 1>{0});
  EXPECT_DOUBLE_EQ(environment.outcome().reward[0], -2);
  EXPECT_DOUBLE_EQ(environment.outcome().success[0], 0);
}

TEST(BatchEnvironment, JudgesAsTheMetricsDo) {
  EnvironmentConfig c = config(16, ActionSpace::kViewpoint, Reward::kProgress);
  c.success_distance = 2.5;
  c.max_steps = 7;
  c.reset_at_next_step = true;
  BatchEnvironment environment(square_episodes(), c);
  environment.reset();
  Rng rng(5);
  int ended = 0;
  for (int step = 0; step < 200; ++step) {
    std::vector<std::int64_t> actions;
    for (std::size_t i = 0; i < c.batch_size; ++i) {
      actions.push_back(static_cast<std::int64_t>(rng.below(4)));
    }
    environment.step(actions);
    const Outcome& out = environment.outcome();
    for (std::size_t i = 0; i < c.batch_size; ++i) {
      if ((out.terminated[i] | out.truncated[i]) == 0) continue;
      const tasks::EpisodeMetrics metrics = environment.compute_metrics(i);
      EXPECT_EQ(out.success[i], metrics.success);
      EXPECT_EQ(out.spl[i], metrics.spl);
      EXPECT_EQ(out.distance[i], metrics.nav_error);
      ++ended;
    }
  }
  EXPECT_GT(ended, 300);
}

TEST(BatchEnvironment, SixActionsTurnLookAndGoForward) {
  BatchEnvironment environment(square_episodes(),
                               config(1, ActionSpace::kSixActions, Reward::kSuccess));
  environment.reset({}, std::array<std::int64_t, 1>{1});
  const auto& state = environment.state();
  const auto act = [&](std::int64_t number) { environment.step(std::array{number}); };
  act(1);
  EXPECT_NEAR(state.heading[0], kPi / 6, 1e-12);
  act(0);
  act(2);
  EXPECT_NEAR(state.elevation[0], kPi / 6, 1e-12);
  act(3);
  for (int i = 0; i < 3; ++i) act(1);  // east, where corner 1 is
  act(4);
  EXPECT_EQ(state.viewpoint[0], ViewpointIndex(1));
  act(5);
  EXPECT_DOUBLE_EQ(environment.outcome().reward[0], 1);
  EXPECT_EQ(environment.outcome().terminated[0], 1);
}

// A cross: v0 in the middle; v1 to the north, v2 to the east, v4 beyond v2; v3 beyond v1.
std::shared_ptr<const tasks::EpisodeSet> cross_episodes() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::connectivity(
      "cross", {{0, 0, 1.5}, {0, 2, 1.5}, {2, 0, 1.5}, {0, 4, 1.5}, {4, 0, 1.5}},
      {{0, 1}, {0, 2}, {1, 3}, {2, 4}}));
  auto set = std::make_shared<tasks::EpisodeSet>();
  set->split = "made";
  set->graphs = graph::GraphSet::of(std::move(graphs));
  const auto v = [](std::size_t i) { return ViewpointIndex(i); };
  set->paths = {{0, ScanIndex(0), Radians(0), {v(0), v(2), v(4)}}};
  set->episodes = {{"0_0", 0, 0, "walk"}};
  return set;
}

TEST(BatchEnvironment, PanoramicActionsGoToCandidatesAndLookAlong) {
  BatchEnvironment environment(cross_episodes(),
                               config(1, ActionSpace::kPanoramic, Reward::kProgress));
  EXPECT_THROW((void)environment.panorama(0), ArgumentError);
  environment.reset();
  EXPECT_THROW((void)environment.map(0), ArgumentError);
  EXPECT_EQ(environment.action_count(), 16);
  const auto& candidates = environment.panorama(0).candidates;
  ASSERT_EQ(candidates.size(), 2U);
  EXPECT_EQ(candidates[0].viewpoint, ViewpointIndex(1));  // north is met first
  EXPECT_EQ(candidates[1].viewpoint, ViewpointIndex(2));
  EXPECT_EQ(environment.expert(0), 2);
  environment.step(std::array<std::int64_t, 1>{3});  // there is none
  EXPECT_EQ(environment.state().viewpoint[0], ViewpointIndex(0));
  environment.step(std::array<std::int64_t, 1>{2});
  EXPECT_EQ(environment.state().viewpoint[0], ViewpointIndex(2));
  EXPECT_EQ(environment.state().view_index[0], 15U);  // east, level
  EXPECT_DOUBLE_EQ(environment.outcome().reward[0], 2);
  environment.step(std::array{environment.expert(0).value()});
  EXPECT_EQ(environment.expert(0), 0);
  environment.step(std::array<std::int64_t, 1>{0});
  EXPECT_EQ(environment.outcome().terminated[0], 1);
  EXPECT_EQ(environment.outcome().actions[0], 4U);
  EXPECT_DOUBLE_EQ(environment.outcome().spl[0], 1);
}

TEST(BatchEnvironment, MapActionsWalkToAnyOpenNodeAsOneAction) {
  EnvironmentConfig c = config(1, ActionSpace::kMap, Reward::kProgress);
  c.max_steps = 4;
  BatchEnvironment environment(cross_episodes(), c);
  environment.reset();
  EXPECT_EQ(environment.action_count(), 6);  // five viewpoints
  const auto act = [&](std::int64_t number) { environment.step(std::array{number}); };
  const auto node = [&](std::size_t viewpoint) {
    return std::int64_t{environment.map(0).find(ViewpointIndex(viewpoint)).value()} + 1;
  };
  EXPECT_EQ(environment.map(0).size(), 3U);
  EXPECT_EQ(environment.expert(0), node(2));
  act(node(1));
  EXPECT_DOUBLE_EQ(environment.outcome().reward[0], -2);
  EXPECT_EQ(environment.map(0).open(), 2U);
  EXPECT_EQ(environment.expert(0), node(2));
  EXPECT_EQ(environment.expert(0, ExpertRule::kNdtw), node(2));
  act(node(0));  // visited: it stays
  EXPECT_EQ(environment.state().viewpoint[0], ViewpointIndex(1));
  act(node(2));  // back through the middle
  EXPECT_EQ(environment.state().viewpoint[0], ViewpointIndex(2));
  EXPECT_EQ(environment.state().view_index[0], 15U);
  EXPECT_DOUBLE_EQ(environment.outcome().reward[0], 4);
  EXPECT_EQ(environment.trajectory(0).points.size(), 5U);
  EXPECT_EQ(environment.trajectory(0).actions, 3U);
  EXPECT_EQ(environment.map(0).step_id(environment.map(0).find(ViewpointIndex(2)).value()), 4U);
  act(node(4));
  EXPECT_EQ(environment.outcome().truncated[0], 1);
  EXPECT_DOUBLE_EQ(environment.outcome().success[0], 1);
  EXPECT_DOUBLE_EQ(environment.outcome().spl[0], 0.5);  // 4 m of 8 m
  environment.reset();
  EXPECT_EQ(environment.map(0).size(), 3U);
}

TEST(BatchEnvironment, EveryActionSpaceHasATeacherThatArrives) {
  for (const ActionSpace space : {ActionSpace::kViewpoint, ActionSpace::kSixActions,
                                  ActionSpace::kPanoramic, ActionSpace::kMap}) {
    BatchEnvironment environment(cross_episodes(), config(2, space, Reward::kSuccess));
    EXPECT_THROW((void)environment.expert(0), ArgumentError);
    environment.reset();
    for (int i = 0; i < 20 && environment.outcome().terminated[0] == 0; ++i) {
      environment.step(std::array{environment.expert(0).value(), environment.expert(1).value()});
    }
    EXPECT_THAT(environment.outcome().reward, ElementsAre(1, 1)) << static_cast<int>(space);
    EXPECT_DOUBLE_EQ(environment.outcome().spl[0], 1);
  }
}

TEST(BatchEnvironment, CutsOffAndBeginsAnewAtTheNextStepIfAsked) {
  EnvironmentConfig c = config(2, ActionSpace::kSixActions, Reward::kNone);
  c.max_steps = 2;
  c.reset_at_next_step = true;
  BatchEnvironment environment(square_episodes(), c);
  environment.reset();
  environment.step(std::array<std::int64_t, 2>{0, 5});
  EXPECT_THAT(environment.outcome().terminated, ElementsAre(0, 1));
  environment.step(std::array<std::int64_t, 2>{0, 0});
  EXPECT_THAT(environment.outcome().truncated, ElementsAre(1, 0));
  EXPECT_THAT(environment.outcome().began, ElementsAre(0, 1));
  EXPECT_EQ(environment.state().step[1], 0U);
}

TEST(BatchEnvironment, WithoutThatAnEndedEpisodeHasToBeReset) {
  BatchEnvironment environment(square_episodes(),
                               config(2, ActionSpace::kSixActions, Reward::kNone));
  EXPECT_THAT(
      [&] {
        environment.step(std::array<std::int64_t, 2>{0, 0});
      },
      ThrowsMessage<ArgumentError>(HasSubstr("reset()")));
  environment.reset();
  environment.step(std::array<std::int64_t, 2>{5, 0});
  EXPECT_THAT(
      [&] {
        environment.step(std::array<std::int64_t, 2>{0, 0});
      },
      ThrowsMessage<ArgumentError>(HasSubstr("agent 0: its episode has ended")));
  environment.reset(std::array<std::uint8_t, 2>{1, 0});
  environment.step(std::array<std::int64_t, 2>{0, 0});
  EXPECT_EQ(environment.state().step[0], 1U);
  EXPECT_EQ(environment.state().step[1], 2U);
}

TEST(BatchEnvironment, SeedsDecideTheEpisodes) {
  const auto drawn = [](std::uint64_t seed) {
    EnvironmentConfig c = config(8, ActionSpace::kSixActions, Reward::kNone);
    c.seed = seed;
    BatchEnvironment environment(square_episodes(), c);
    std::vector<std::uint32_t> found;
    for (int i = 0; i < 4; ++i) {
      environment.reset();
      const auto& e = environment.outcome().episode;
      found.insert(found.end(), e.begin(), e.end());
    }
    return found;
  };
  EXPECT_EQ(drawn(3), drawn(3));
  EXPECT_NE(drawn(3), drawn(4));
}

TEST(BatchEnvironment, RefusesWhatCannotBe) {
  const auto refused = [](const EnvironmentConfig& c, const char* words) {
    EXPECT_THAT([&] { BatchEnvironment(square_episodes(), c); },
                ThrowsMessage<ArgumentError>(HasSubstr(words)));
  };
  EnvironmentConfig c;
  c.max_steps = 0;
  refused(c, "max_steps");
  c = {};
  c.success_distance = std::nan("");
  refused(c, "success_distance");
  c = {};
  c.max_navigable = 2;
  refused(c, "2 neighbours");
  auto hidden = std::make_shared<tasks::EpisodeSet>(*square_episodes());
  hidden->paths[1].viewpoints.resize(1);
  EXPECT_THAT([&] { BatchEnvironment(hidden, EnvironmentConfig{}); },
              ThrowsMessage<ArgumentError>(HasSubstr("hides its goals (path 1)")));
  BatchEnvironment environment(square_episodes(), EnvironmentConfig{});
  EXPECT_THROW(environment.reset(std::array<std::uint8_t, 1>{0}), ArgumentError);
  EXPECT_THROW(environment.reset({}, std::array<std::int64_t, 1>{2}), ArgumentError);
  environment.reset();
  EXPECT_THROW(environment.step(std::array<std::int64_t, 1>{16}), ArgumentError);
  EXPECT_THROW(environment.step(std::array<std::int64_t, 2>{0, 0}), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
