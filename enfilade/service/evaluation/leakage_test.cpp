#include "enfilade/service/evaluation/leakage.h"

#include <gtest/gtest.h>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/benchmark.h"
#include "tests/support/graphs.h"

namespace enfilade::service::evaluation {
namespace EN_UNIT {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-9;  // of sums of some hundred logarithms, and far below a bit

Phase secret_phase(Scores scores) {
  Phase phase;
  phase.name = "test";
  phase.annotations = "secret.json";
  phase.scores = scores;
  phase.per_team = 20;
  return phase;
}

/// One of each kind of grid: shares, errors, progress.
std::vector<tasks::Measure> measures_of_grids() {
  const auto own = tasks::benchmark(tasks::Task::kR2r).scorers.front().columns;
  return {*tasks::find_measure(own, "spl"), *tasks::find_measure(own, "nav_error"),
          tasks::benchmark(tasks::Task::kCvdn).headline()};
}

/// How many different answers a ladder can give to n submissions with L levels, by trying all
/// sequences of scores.
std::size_t count_transcripts(int submissions, int levels) {
  std::set<std::vector<int>> transcripts;
  const std::function<void(const std::vector<int>&, int)> go_on = [&](const std::vector<int>& shown,
                                                                      int best) {
    if (static_cast<int>(shown.size()) == submissions) {
      transcripts.insert(shown);
      return;
    }
    for (int score = 0; score < levels; ++score) {
      std::vector<int> next = shown;
      const bool better = score > best;
      next.push_back(better ? score : -1);
      go_on(next, better ? score : best);
    }
  };
  go_on({}, -1);
  return transcripts.size();
}

TEST(Leakage, ALadderGivesAwayTheLogarithmOfItsTranscripts) {
  for (int submissions = 0; submissions <= 5; ++submissions) {
    for (int levels = 1; levels <= 5; ++levels) {
      EXPECT_NEAR(ladder_bits(submissions, levels),
                  std::log2(static_cast<double>(count_transcripts(submissions, levels))), kRounding)
          << submissions << " " << levels;
    }
  }
}

TEST(Leakage, ARowGivesAwayWhichAndHowGood) {
  // Six shares on 0, 0.5, 1 are log2 3 bits each; metres on 0, 5, ... 30 are log2 7.
  Phase phase = secret_phase(Scores::kAfterEnd);
  phase.step = 0.5;
  EXPECT_NEAR(means_bits(phase), 6 * std::log2(3) + std::log2(7), kRounding);
  EXPECT_NEAR(row_bits(means_bits(phase), 8), 3 + 6 * std::log2(3) + std::log2(7), kRounding);
  EXPECT_EQ(row_bits(means_bits(phase), 0), 0);
}

TEST(Leakage, WhatIsNotShownGivesNothingAway) {
  EXPECT_EQ(team_bits(secret_phase(Scores::kAfterEnd), 20, false), 0);
  EXPECT_EQ(team_bits(secret_phase(Scores::kHidden), 20, true), 0);
  EXPECT_EQ(most_bits(secret_phase(Scores::kHidden)), 0);
  EXPECT_EQ(most_bits(Phase{}), 0);  // of open goals there is nothing to give away
}

TEST(Leakage, ALadderAndARowAddUp) {
  const Phase phase = secret_phase(Scores::kLadder);
  EXPECT_NEAR(team_bits(phase, 20, false), ladder_bits(20, 101), kRounding);
  EXPECT_NEAR(team_bits(phase, 20, true), ladder_bits(20, 101) + row_bits(means_bits(phase), 20),
              kRounding);
  EXPECT_NEAR(most_bits(phase), phase.teams * team_bits(phase, 20, true), kRounding);
}

TEST(Leakage, WithoutALimitThereIsNoBound) {
  Phase phase = secret_phase(Scores::kAfterEnd);
  phase.per_team.reset();
  EXPECT_EQ(most_bits(phase), std::numeric_limits<double>::infinity());
}

TEST(Leakage, AGoalIsAnyViewpointInReachOfItsStart) {
  // A square of four, and a fifth viewpoint that nobody can reach.
  const auto graph =
      graph::testing::connectivity("scan", {{0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}, {9, 9, 1}},
                                   {{0, 1}, {1, 2}, {2, 3}, {3, 0}});
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph);
  tasks::Annotations annotations{"test", "", {}};
  for (std::int64_t id = 1; id <= 3; ++id) {
    // Three instructions of a path have one goal, and so may two entries with one start.
    annotations.paths.push_back({id,
                                 "scan",
                                 Radians(0),
                                 {id == 3 ? "v3" : "v0", id == 3 ? "v0" : "v1"},
                                 2.0,
                                 {"Walk.", "Go.", "Move."}});
  }
  const auto episodes = tasks::make_episodes(annotations, graph::GraphSet::of(std::move(graphs)));
  EXPECT_EQ(episodes.episodes.size(), 9U);
  EXPECT_NEAR(goal_bits(tasks::Split(episodes), *episodes.graphs), 2 * std::log2(3), kRounding);
  // The same as walks: two episodes of one path, which starts on the floor under v1.
  auto goals = std::make_shared<tasks::ContinuousEpisodes>();
  for (std::int64_t id = 1; id <= 2; ++id) {
    tasks::ContinuousEpisode& one = goals->episodes.emplace_back();
    one.id = id;
    one.trajectory_id = std::int64_t{7};
    one.scene = "mp3d/scan/scan.glb";
    one.start = {2, 0, 0};
  }
  const tasks::Split split(tasks::benchmark("r2r-ce"), std::move(goals));
  EXPECT_NEAR(goal_bits(split, *episodes.graphs), std::log2(3), kRounding);
}

TEST(Leakage, AGridHasAsManyValuesAsItSays) {
  for (const double step : {0.001, 0.01, 0.02, 0.03, 0.05, 0.1, 0.3, 0.5}) {
    Phase phase = secret_phase(Scores::kAfterEnd);
    phase.step = step;
    for (const tasks::Measure& measure : measures_of_grids()) {
      const Grid grid = grid_of(phase, measure);
      std::set<double> values;
      for (int k = 0; k <= 100'000; ++k) {
        values.insert(grid.round(grid.least + (grid.most - grid.least) * k / 100'000));
      }
      EXPECT_EQ(static_cast<std::int64_t>(values.size()), grid.levels()) << step;
      for (const double value : values) EXPECT_EQ(grid.round(value), value);
    }
  }
}

TEST(Leakage, WhatIsBeyondAGridIsItsEnd) {
  const Phase phase = secret_phase(Scores::kAfterEnd);
  const Grid metres = grid_of(phase, *tasks::find_measure(phase.measures(), "nav_error"));
  EXPECT_EQ(metres.round(1234), 30);
  EXPECT_EQ(metres.round(kInfinite), 30);
  EXPECT_EQ(metres.round(0.07), 0.1);
  const Grid shares = grid_of(phase, *tasks::find_measure(phase.measures(), "spl"));
  EXPECT_EQ(shares.round(0.0749), 0.07);
  EXPECT_EQ(shares.round(-kInfinite), 0);
  EXPECT_EQ(shares.round(std::numeric_limits<double>::quiet_NaN()), 0);
  const Grid progress = grid_of(phase, tasks::benchmark(tasks::Task::kCvdn).headline());
  EXPECT_EQ(progress.round(-3.14), -3.1);
  EXPECT_EQ(progress.round(-kInfinite), -30);
  EXPECT_EQ(progress.levels(), 601);
}

TEST(Leakage, ARowOfAnotherBenchmarkHasItsColumns) {
  Phase phase = secret_phase(Scores::kAfterEnd);
  phase.benchmark = &tasks::benchmark(tasks::Task::kCvdn);
  phase.scorer = &phase.benchmark->scorer("hamt");
  phase.primary = "gp";
  phase.step = 0.5;
  // SR, OSR and SPL on 0, 0.5, 1; metres of progress on -30, -25, ... 30.
  EXPECT_NEAR(means_bits(phase), 3 * std::log2(3) + std::log2(13), kRounding);
  phase.scores = Scores::kLadder;
  EXPECT_NEAR(team_bits(phase, 4, false), ladder_bits(4, 13), kRounding);
}

}  // namespace EN_UNIT
}  // namespace enfilade::service::evaluation
