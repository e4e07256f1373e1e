#include "enfilade/agents/pilot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <vector>

#include "enfilade/agents/run.h"
#include "enfilade/core/errors.h"
#include "tests/support/graphs.h"

namespace enfilade::agents {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

// Paths on a square of side 2 m from corner 0, heading north, to corner 2, and to corner 1.
std::shared_ptr<const tasks::EpisodeSet> square_episodes() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square());
  auto set = std::make_shared<tasks::EpisodeSet>();
  set->split = "made";
  set->graphs = graph::GraphSet::of(std::move(graphs));
  set->paths = {{0, ScanIndex(0), Radians(0), {v(0), v(1), v(2)}},
                {1, ScanIndex(0), Radians(0), {v(0), v(1)}}};
  set->episodes = {{"0_0", 0, 0, "walk"}, {"1_0", 1, 0, "walk"}};
  return set;
}

// The number of a move in an environment's action space.
std::int64_t number_of(const PilotMove& move, const BatchEnvironment& environment, std::size_t i) {
  const std::size_t m = environment.config().max_navigable;
  switch (environment.config().actions) {
    case ActionSpace::kSixActions:
      return static_cast<std::int64_t>(move.action);
    case ActionSpace::kViewpoint:
      for (std::size_t k = 1; !move.stop && k < m; ++k) {
        if (environment.state().navigable_viewpoint[i * m + k] == move.to) {
          return static_cast<std::int64_t>(k);
        }
      }
      return 0;
    case ActionSpace::kPanoramic: {
      const auto& candidates = environment.panorama(i).candidates;
      for (std::size_t k = 0; !move.stop && k < candidates.size(); ++k) {
        if (candidates[k].viewpoint == move.to) return static_cast<std::int64_t>(k + 1);
      }
      return 0;
    }
    case ActionSpace::kMap:
      return move.stop ? 0 : environment.map(i).find(move.to).value() + 1;
  }
  return 0;
}

class PilotIn : public ::testing::TestWithParam<ActionSpace> {};

TEST_P(PilotIn, AnEnvironmentGoesWhereTheAgentGoesAlone) {
  const auto episodes = square_episodes();
  const auto shortest = make_agent("shortest");
  const std::vector<tasks::Trajectory> alone = run_agent(*shortest, *episodes);
  EnvironmentConfig config;
  config.batch_size = 2;
  config.actions = GetParam();
  config.success_distance = 1;
  BatchEnvironment environment(episodes, config);
  environment.reset({}, std::array<std::int64_t, 2>{0, 1});
  Pilot pilot(*shortest, *episodes, config.actions);
  pilot.begin(std::array<std::size_t, 2>{0, 1});
  std::vector<PilotMove> moves(2);
  std::vector<std::uint8_t> running(2, 1);
  for (int step = 0; step < 20 && (running[0] || running[1]); ++step) {
    const std::vector<ViewpointIndex> here(environment.state().viewpoint.begin(),
                                           environment.state().viewpoint.end());
    pilot.next(here, running, moves);
    std::vector<std::int64_t> numbers;
    for (std::size_t i = 0; i < 2; ++i) numbers.push_back(number_of(moves[i], environment, i));
    // An ended episode has to begin anew before a step: it is put back, and not asked any more.
    for (std::size_t i = 0; i < 2; ++i) {
      if (running[i]) continue;
      std::vector<std::uint8_t> mask(2, 0);
      mask[i] = 1;
      environment.reset(mask, std::array<std::int64_t, 2>{0, 1});
    }
    environment.step(numbers);
    for (std::size_t i = 0; i < 2; ++i) {
      if (!running[i] || environment.outcome().terminated[i] == 0) continue;
      running[i] = 0;
      EXPECT_EQ(environment.state().viewpoint[i], alone[i].points.back().viewpoint) << i;
      EXPECT_EQ(environment.outcome().success[i], 1) << i;
    }
  }
  EXPECT_EQ(running[0] + running[1], 0) << "both have stopped";
}

INSTANTIATE_TEST_SUITE_P(All, PilotIn,
                         ::testing::Values(ActionSpace::kViewpoint, ActionSpace::kSixActions,
                                           ActionSpace::kPanoramic, ActionSpace::kMap));

// Goes 0, 1, 0, 3 and stops, whatever the episode says: back through a visited viewpoint.
class BackAndForth : public Agent {
 public:
  std::string_view name() const override { return "back and forth"; }
  void start(std::span<const Observation> /*batch*/) override { next_ = 0; }
  void act(std::span<const Observation> batch, std::span<Decision> decisions) override {
    constexpr std::array<std::size_t, 3> kWay{1, 0, 3};
    const Observation& seen = batch[0];
    if (next_ == kWay.size()) {
      decisions[0] = Decision::stop_with({.object = "66"});
      return;
    }
    for (std::uint32_t k = 1; k < seen.navigable.size(); ++k) {
      if (seen.navigable.viewpoint[k] != v(kWay[next_])) continue;
      decisions[0] = Decision::go(k);
      ++next_;
      return;
    }
    decisions[0] = Decision::turn(0.5);
  }

 private:
  std::size_t next_ = 0;
};

TEST(Pilot, OnAMapItGoesThroughVisitedPlacesAtOnce) {
  const auto episodes = square_episodes();
  BackAndForth agent;
  Pilot pilot(agent, *episodes, ActionSpace::kMap);
  pilot.begin(std::array<std::size_t, 1>{0});
  std::array<PilotMove, 1> move;
  const std::array<std::uint8_t, 1> asked{1};
  const auto next = [&](std::size_t here) {
    pilot.next(std::array{v(here)}, asked, move);
    return move[0];
  };
  EXPECT_EQ(next(0).to, v(1));
  EXPECT_EQ(next(1).to, v(3)) << "through 0";
  const PilotMove last = next(3);
  EXPECT_TRUE(last.stop);
  EXPECT_EQ(last.answer.value().object, "66");
  EXPECT_TRUE(next(3).stop) << "it stays so";
}

TEST(Pilot, InAListItGoesFromNeighbourToNeighbour) {
  const auto episodes = square_episodes();
  BackAndForth agent;
  Pilot pilot(agent, *episodes, ActionSpace::kViewpoint);
  pilot.begin(std::array<std::size_t, 1>{0});
  std::array<PilotMove, 1> move;
  const std::array<std::uint8_t, 1> asked{1};
  for (const unsigned here : {0U, 1U, 0U}) {
    pilot.next(std::array{v(here)}, asked, move);
    EXPECT_FALSE(move[0].stop);
  }
  EXPECT_EQ(move[0].to, v(3));
}

TEST(Pilot, ASlotThatStandsElsewhereIsRefused) {
  const auto episodes = square_episodes();
  BackAndForth agent;
  Pilot pilot(agent, *episodes, ActionSpace::kViewpoint);
  pilot.begin(std::array<std::size_t, 1>{0});
  std::array<PilotMove, 1> move;
  EXPECT_THAT([&] { pilot.next(std::array{v(2)}, std::array<std::uint8_t, 1>{1}, move); },
              ThrowsMessage<ArgumentError>(HasSubstr("take its actions")));
  EXPECT_THROW(pilot.next({}, {}, move), ArgumentError);
  pilot.next(std::array{v(2)}, std::array<std::uint8_t, 1>{0}, move);
  EXPECT_TRUE(move[0].stop) << "nobody asked";
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
