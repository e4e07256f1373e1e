#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "enfilade/agents/run.h"
#include "enfilade/agents/simple_agents.h"
#include "enfilade/core/errors.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/score_table.h"
#include "enfilade/tasks/statistics.h"
#include "tests/support/graphs.h"

namespace enfilade::agents {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

// Episodes over one graph: path k from `starts[k]` to `goals[k]`.
tasks::EpisodeSet episodes_on(const scan::Connectivity& connectivity,
                              const std::vector<std::pair<int, int>>& ends) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(connectivity);
  tasks::EpisodeSet set{"made", graph::GraphSet::of(std::move(graphs)), {}, {}};
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const auto path = set.graphs->graph(ScanIndex(0))
                          .path(v(static_cast<std::size_t>(ends[i].first)),
                                v(static_cast<std::size_t>(ends[i].second)));
    set.paths.push_back({static_cast<std::int64_t>(i), ScanIndex(0), Radians(0), path.value()});
    set.episodes.push_back({tasks::instruction_id(static_cast<std::int64_t>(i), 0), i, 0, "walk"});
  }
  return set;
}

std::vector<ViewpointIndex> moves(const tasks::Trajectory& trajectory) {
  std::vector<ViewpointIndex> places;
  for (const tasks::TrajectoryPoint& point : trajectory.points) {
    if (places.empty() || places.back() != point.viewpoint) places.push_back(point.viewpoint);
  }
  return places;
}

TEST(ShortestAgent, TakesTheShortestPathWhateverItsHeading) {
  const tasks::EpisodeSet set =
      episodes_on(graph::testing::square(), {{0, 2}, {2, 0}, {1, 3}, {3, 1}, {0, 1}, {2, 3}});
  ShortestAgent agent;
  const auto trajectories = run_agent(agent, set);
  ASSERT_EQ(trajectories.size(), set.episodes.size());
  for (const tasks::Trajectory& one : trajectories) {
    EXPECT_EQ(moves(one), set.paths[set.episodes[one.episode].path].viewpoints);
  }
}

TEST(ShortestAgent, LooksUpStairs) {
  // The goal is 60 degrees above the start: visible when level, reached after one look up.
  const tasks::EpisodeSet set = episodes_on(
      graph::testing::connectivity("s", {{0, 0, 0}, {0, 1, std::sqrt(3.0)}}, {{0, 1}}), {{0, 1}});
  ShortestAgent agent;
  const auto points = run_agent(agent, set).at(0).points;
  ASSERT_EQ(points.size(), 3U);
  EXPECT_NEAR(to_degrees(points[1].elevation), 30, 1e-9);
  EXPECT_EQ(points[2].viewpoint, v(1));
}

TEST(ShortestAgent, TurnsTheShorterWayToWhatItCannotSee) {
  // From heading 0 the neighbour at 240 degrees is 4 views to the left, 8 to the right.
  const double a = degrees(240).value;
  const tasks::EpisodeSet set =
      episodes_on(graph::testing::connectivity(
                      "s", {{0, 0, 0}, {2 * std::sin(a), 2 * std::cos(a), 0}}, {{0, 1}}),
                  {{0, 1}});
  ShortestAgent agent;
  const auto points = run_agent(agent, set).at(0).points;
  // Three turns bring it within 30 degrees (rel_heading -30 is not below -30), then it walks.
  EXPECT_LE(points.size(), 6U);
  EXPECT_NEAR(to_degrees(points[1].heading), 330, 1e-9);
}

TEST(ShortestAgent, NeedsTheGoal) {
  tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 2}});
  set.paths[0].viewpoints.resize(1);
  ShortestAgent agent;
  EXPECT_THAT([&] { run_agent(agent, set); },
              ThrowsMessage<ArgumentError>(HasSubstr("needs the goal, which split made hides")));
}

TEST(RandomAgent, MakesFiveMovesAndTurnsRightOnly) {
  const tasks::EpisodeSet set =
      episodes_on(graph::testing::square(), std::vector<std::pair<int, int>>(40, std::pair(0, 2)));
  RandomAgent agent;
  for (const tasks::Trajectory& one : run_agent(agent, set)) {
    int walked = 0;
    for (std::size_t i = 1; i < one.points.size(); ++i) {
      const bool moved = one.points[i].viewpoint != one.points[i - 1].viewpoint;
      const double turned =
          wrap_difference(one.points[i].heading - one.points[i - 1].heading).value;
      EXPECT_NEAR(to_degrees(Radians(turned)), moved ? 0 : 30, 1e-9);
      walked += moved ? 1 : 0;
    }
    EXPECT_EQ(walked, RandomAgent::kMoves);
  }
}

TEST(RandomAgent, IsEndedWhereThereIsNowhereToGo) {
  const tasks::EpisodeSet set =
      episodes_on(graph::testing::connectivity("s", {{0, 0, 0}}, {}), {{0, 0}});
  RandomAgent agent;
  RunOptions options;
  options.max_actions = 40;
  EXPECT_EQ(run_agent(agent, set, options).at(0).points.size(), 41U);
}

TEST(RunAgent, BatchSizeChangesNothingAndSeedsDo) {
  const tasks::EpisodeSet set =
      episodes_on(graph::testing::square(), std::vector<std::pair<int, int>>(30, std::pair(0, 2)));
  RandomAgent agent;
  const auto with = [&](std::size_t batch, std::uint64_t seed) {
    RunOptions options;
    options.batch_size = batch;
    options.seed = seed;
    return tasks::to_json(run_agent(agent, set, options), set);
  };
  EXPECT_EQ(with(1, 1), with(7, 1));
  EXPECT_EQ(with(1, 1), with(100, 1));
  EXPECT_NE(with(1, 1), with(1, 2));
}

// An agent that a reader of docs/agents.md might write.
class StubbornAgent : public Agent {
 public:
  std::string_view name() const override { return "stubborn"; }
  void start(std::span<const Observation>) override {}
  void act(std::span<const Observation> batch, std::span<Decision> decisions) override {
    for (std::size_t i = 0; i < batch.size(); ++i) decisions[i] = Decision::go(99);
  }
};

TEST(RunAgent, SaysWhatAnAgentDidWrong) {
  const tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 2}});
  StubbornAgent agent;
  EXPECT_THAT([&] { run_agent(agent, set); }, ThrowsMessage<sim::ActionError>(HasSubstr("99")));
  RunOptions none;
  none.batch_size = 0;
  EXPECT_THROW(run_agent(agent, set, none), ArgumentError);
  EXPECT_THROW(make_agent("clever"), LookupError);
}

tasks::EpisodeSet real_split(const scan::DataRoot& data, const char* split) {
  return tasks::make_episodes(tasks::load_annotations(data.annotations(split), split),
                              graph::GraphSet::open_shared(data.connectivity()));
}

double mean_of(const std::vector<tasks::EpisodeMetrics>& all,
               double tasks::EpisodeMetrics::*field) {
  double sum = 0;
  for (const tasks::EpisodeMetrics& one : all) sum += one.*field;
  return sum / static_cast<double>(all.size());
}

TEST(PaperTable, Shortest) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no R2R annotations";
  const std::vector<std::pair<const char*, double>> rows{{"val_seen", 10.19}, {"val_unseen", 9.48}};
  for (const auto& [split, length] : rows) {
    const tasks::EpisodeSet set = real_split(*data, split);
    ShortestAgent agent;
    const auto all = tasks::score_trajectories(run_agent(agent, set), set, {}, 0);
    // The paper prints two digits.
    EXPECT_NEAR(mean_of(all, &tasks::EpisodeMetrics::trajectory_length), length, 0.005) << split;
    EXPECT_EQ(mean_of(all, &tasks::EpisodeMetrics::success), 1) << split;
    EXPECT_EQ(mean_of(all, &tasks::EpisodeMetrics::nav_error), 0) << split;
  }
}

TEST(PaperTable, RandomIsWithinTwoAndAHalfDeviations) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no R2R annotations";
  struct Expected {
    const char* split;
    double length, nav_error, success, oracle_success;
  };
  for (const Expected& paper : {Expected{"val_seen", 9.58, 9.45, 0.159, 0.214},
                                Expected{"val_unseen", 9.77, 9.23, 0.163, 0.220}}) {
    const tasks::EpisodeSet set = real_split(*data, paper.split);
    RandomAgent agent;
    std::vector<double> length, nav_error, success, oracle_success;
    for (std::uint64_t seed = 1; seed <= 25; ++seed) {
      RunOptions options;
      options.seed = seed;
      const auto all = tasks::score_trajectories(run_agent(agent, set, options), set, {}, 0);
      length.push_back(mean_of(all, &tasks::EpisodeMetrics::trajectory_length));
      nav_error.push_back(mean_of(all, &tasks::EpisodeMetrics::nav_error));
      success.push_back(mean_of(all, &tasks::EpisodeMetrics::success));
      oracle_success.push_back(mean_of(all, &tasks::EpisodeMetrics::oracle_success));
    }
    // The paper's figure is one run: 2.5 standard deviations of a run hold 98.8 % of them.
    const auto expect = [&](std::vector<double> seeds, double published, const char* what) {
      const tasks::Summary s = tasks::summarise(std::move(seeds));
      EXPECT_NEAR(s.mean, published, 2.5 * s.deviation) << what << " on " << paper.split;
    };
    expect(length, paper.length, "TL");
    expect(nav_error, paper.nav_error, "NE");
    expect(success, paper.success, "SR");
    expect(oracle_success, paper.oracle_success, "OSR");
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
