#include "enfilade/tasks/continuous_measures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"

namespace enfilade::tasks {
namespace EN_UNIT {

ContinuousEpisodes three_episodes() {
  ContinuousEpisodes episodes;
  episodes.split = "val_unseen";
  for (const std::int64_t id : {1, 2, 3}) {
    ContinuousEpisode episode;
    episode.id = id;
    episode.trajectory_id = id < 3 ? std::int64_t{7} : std::int64_t{8};
    episodes.episodes.push_back(episode);
  }
  return episodes;
}

std::vector<ContinuousResult> walks_of(const std::vector<std::size_t>& episodes) {
  std::vector<ContinuousResult> walks;
  for (const std::size_t e : episodes) walks.emplace_back().episode = e;
  return walks;
}

std::vector<ContinuousScore> scores_of(const std::vector<double>& successes) {
  std::vector<ContinuousScore> scores;
  for (const double success : successes) {
    ContinuousScore& score = scores.emplace_back();
    score.success = score.spl = success;
    score.path_length = 4;
  }
  return scores;
}

TEST(ContinuousMeasures, AreMeansOverEpisodesDrawnByTrajectories) {
  const auto scores = scores_of({1, 1, 0});
  const auto walks = walks_of({0, 1, 2});
  const ContinuousMeasures m = measure(scores, walks, three_episodes());
  EXPECT_EQ(m.episodes, 3U);
  EXPECT_EQ(m.trajectories, 2U);
  EXPECT_DOUBLE_EQ(m.means[0].mean, 4);
  EXPECT_DOUBLE_EQ(m.means[2].mean, 2.0 / 3);
  // Either trajectory alone may be drawn twice.
  EXPECT_DOUBLE_EQ(m.means[2].low, 0);
  EXPECT_DOUBLE_EQ(m.means[2].high, 1);
}

TEST(ContinuousMeasures, UnknownOnesAreLeftOut) {
  auto scores = scores_of({1});
  const auto walks = walks_of({2});
  const ContinuousEpisodes episodes = three_episodes();
  EXPECT_THAT(to_table(measure(scores, walks, episodes)), ::testing::Not(::testing::HasSubstr("coll")));
  const auto json = nlohmann::json::parse(
      to_json(measure(scores, walks, episodes), scores, walks, episodes, true));
  EXPECT_TRUE(json["means"]["collisions"]["mean"].is_null());
  EXPECT_EQ(json["per_episode"]["3"]["success"], 1);
  scores[0].collisions = 2;
  EXPECT_THAT(to_table(measure(scores, walks, episodes)), ::testing::HasSubstr("collisions"));
}

TEST(ContinuousMeasures, NeedAScoreAWalk) {
  const auto scores = scores_of({1, 0});
  EXPECT_THROW(measure(scores, walks_of({0}), three_episodes()), ArgumentError);
  EXPECT_THROW(measure({}, {}, three_episodes()), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
