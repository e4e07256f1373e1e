#include "enfilade/tasks/score.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "enfilade/core/rng.h"
#include "enfilade/scan/data_root.h"
#include "tests/support/graphs.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;

// `paths` paths v0 v1 v2 of a row of viewpoints 2 m apart, three instructions each; v4 stands
// alone.
EpisodeSet row_episodes(std::int64_t paths) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::connectivity(
      "row", {{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {6, 0, 0}, {0, 9, 0}}, {{0, 1}, {1, 2}, {2, 3}}));
  Annotations annotations{"val", "val.json", {}};
  for (std::int64_t id = 0; id < paths; ++id) {
    annotations.paths.push_back(
        {id, "row", Radians(0), {"v0", "v1", "v2"}, 4.0, {"Go.", "Walk.", "Move."}});
  }
  return make_episodes(annotations, graph::GraphSet::of(std::move(graphs)));
}

Trajectory straight(std::size_t episode, std::size_t viewpoints) {
  Trajectory trajectory{episode, {}};
  for (std::size_t i = 0; i < viewpoints; ++i) {
    trajectory.points.push_back({ViewpointIndex(i), {}, {}});
  }
  return trajectory;
}

// Of 1 to 4 viewpoints, at random.
std::vector<Trajectory> random_trajectories(const EpisodeSet& episodes) {
  Rng rng(3);
  std::vector<Trajectory> trajectories;
  for (std::size_t i = 0; i < episodes.episodes.size(); ++i) {
    trajectories.push_back(straight(i, 1 + rng.below(4)));
  }
  return trajectories;
}

TEST(Score, MeansAreOfTheEpisodes) {
  const EpisodeSet episodes = row_episodes(1);
  const Score score = compute_score({straight(0, 3), straight(1, 1), straight(2, 4)}, episodes);
  ASSERT_EQ(score.episodes.size(), 3U);
  EXPECT_EQ(score.episodes[1].nav_error, 4);
  EXPECT_EQ(score.mean("nav_error").mean, 2) << "(0 + 4 + 2) / 3";
  EXPECT_EQ(score.mean("trajectory_length").mean, 10.0 / 3);
  EXPECT_EQ(score.mean("success").mean, 2.0 / 3);
  EXPECT_EQ(score.mean("success").low, score.mean("success").high) << "one path, no other to draw";
  EXPECT_THROW(score.mean("sr"), LookupError);
}

TEST(Score, PutsTrajectoriesInTheOrderOfEpisodes) {
  const EpisodeSet episodes = row_episodes(1);
  const Score score = compute_score({straight(2, 4), straight(0, 3), straight(1, 1)}, episodes);
  EXPECT_EQ(score.episodes[0].nav_error, 0);
  EXPECT_EQ(score.episodes[1].nav_error, 4);
  EXPECT_EQ(score.episodes[2].nav_error, 2);
}

TEST(Score, ThreadsChangeNothing) {
  const EpisodeSet episodes = row_episodes(500);
  const auto trajectories = random_trajectories(episodes);
  ScoreOptions options;
  options.threads = 1;
  const std::string one = to_json(compute_score(trajectories, episodes, options), episodes);
  options.threads = 4;
  EXPECT_EQ(to_json(compute_score(trajectories, episodes, options), episodes), one);
}

TEST(Score, RefusesWhatCannotBeScored) {
  const EpisodeSet episodes = row_episodes(1);
  const auto score = [&](const std::vector<Trajectory>& t) { return compute_score(t, episodes); };
  EXPECT_THROW(score({straight(0, 3), straight(1, 3)}), ArgumentError) << "one is missing";
  EXPECT_THROW(score({straight(0, 3), straight(1, 3), straight(1, 3)}), ArgumentError) << "twice";
  EXPECT_THROW(score({straight(0, 3), straight(1, 3), straight(3, 3)}), ArgumentError)
      << "no such episode";
  EXPECT_THROW(score({straight(0, 3), straight(1, 3), straight(2, 0)}), ArgumentError) << "empty";
  EXPECT_THROW(score({straight(0, 3), straight(1, 3), straight(2, 6)}), ArgumentError)
      << "no such viewpoint";
  EXPECT_THROW(score_trajectories({}, episodes, {0}, 1), ArgumentError);
}

TEST(Score, HiddenGoalsCannotBeScored) {
  EpisodeSet episodes = row_episodes(2);
  EXPECT_FALSE(goals_hidden(episodes));
  episodes.paths[1].viewpoints.resize(1);
  EXPECT_TRUE(goals_hidden(episodes));
  EXPECT_THROW(compute_score(random_trajectories(episodes), episodes), ArgumentError);
}

TEST(Score, JsonHasEveryFieldByName) {
  const EpisodeSet episodes = row_episodes(20);
  const Score score = compute_score(random_trajectories(episodes), episodes);
  const auto json = nlohmann::json::parse(to_json(score, episodes));
  EXPECT_EQ(json["split"], "val");
  EXPECT_EQ(json["episodes"], 60);
  EXPECT_EQ(json["options"]["success_distance"], 3.0);
  for (const MetricField& field : metric_fields()) {
    const MeanInterval& mean = score.mean(field.name);
    EXPECT_EQ(json["means"][field.name]["mean"], mean.mean) << field.name;
    EXPECT_EQ(json["means"][field.name]["low"], mean.low) << field.name;
    EXPECT_EQ(json["means"][field.name]["high"], mean.high) << field.name;
    EXPECT_EQ(json["per_episode"]["19_2"][field.name], score.episodes.back().*field.field);
  }
  EXPECT_FALSE(nlohmann::json::parse(to_json(score)).contains("per_episode"));
}

TEST(Score, JsonOfWhatIsOutOfReachIsNull) {
  const EpisodeSet episodes = row_episodes(1);
  std::vector<Trajectory> trajectories{straight(0, 3), straight(1, 3), straight(2, 1)};
  trajectories[2].points[0].viewpoint = ViewpointIndex(4);
  const Score score = compute_score(trajectories, episodes);
  const auto json = nlohmann::json::parse(to_json(score, episodes));
  EXPECT_TRUE(json["per_episode"]["0_2"]["nav_error"].is_null());
  EXPECT_TRUE(json["means"]["nav_error"]["mean"].is_null());
  EXPECT_EQ(json["means"]["success"]["mean"], 2.0 / 3);
}

TEST(Score, TableIsForReading) {
  const EpisodeSet episodes = row_episodes(1);
  const std::vector<Trajectory> trajectories{straight(0, 3), straight(1, 1), straight(2, 4)};
  ScoreOptions options;
  const std::string table = to_table(compute_score(trajectories, episodes, options));
  EXPECT_THAT(table, HasSubstr("val: 3 episodes\n"));
  EXPECT_THAT(table, HasSubstr("TL (m)        3.33   [3.33, 3.33]\n"));
  EXPECT_THAT(table, HasSubstr("SR (%)        66.7   [66.7, 66.7]\n"));
  EXPECT_THAT(table, HasSubstr("steps         1.67"));
  options.bootstrap_samples = 0;
  const Score plain = compute_score(trajectories, episodes, options);
  EXPECT_THAT(to_table(plain), HasSubstr("NE (m)        2.00\n"));
  EXPECT_FALSE(nlohmann::json::parse(to_json(plain))["means"]["success"].contains("low"));
}

TEST(Score, TableShowsTheSplThatWasAskedFor) {
  EpisodeSet episodes = row_episodes(1);
  // A reference with a detour: 8 m for a shortest path of 4 m, which the trajectories take.
  for (const std::size_t v : {1U, 2U}) episodes.paths[0].viewpoints.emplace_back(v);
  const auto taken = {straight(0, 3), straight(1, 3), straight(2, 3)};
  const Score score = compute_score(taken, episodes);
  EXPECT_EQ(score.mean("spl").mean, 1);
  EXPECT_EQ(score.mean("spl_refpath").mean, 1) << "8 / max(4, 8)";
  EXPECT_THAT(to_table(score), Not(HasSubstr("SPL*")));
  EXPECT_THAT(to_table(score, SplLength::kReference),
              HasSubstr("* against the length of the reference path"));
}

// What a perfect agent hands in: the shortest path of each episode.
std::vector<Trajectory> shortest_paths(const EpisodeSet& episodes) {
  std::vector<Trajectory> trajectories;
  for (const Episode& episode : episodes.episodes) {
    const auto& reference = episodes.path_of(episode).viewpoints;
    Trajectory& trajectory = trajectories.emplace_back();
    trajectory.episode = trajectories.size() - 1;
    const auto path = episodes.graph_of(episode).path(reference.front(), reference.back());
    for (const ViewpointIndex v : path.value()) {
      trajectory.points.push_back({v, {}, {}});
    }
  }
  return trajectories;
}

TEST(Score, OfRealShortestPathsIsThePapersRow) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real annotations";
  const auto graphs = graph::GraphSet::open(data->connectivity());
  // The paper's table 1, row Shortest.
  for (const auto& [split, length] :
       {std::pair{"val_seen", 10.19}, std::pair{"val_unseen", 9.48}}) {
    const EpisodeSet episodes =
        make_episodes(load_annotations(data->annotations(split), split), graphs);
    const auto trajectories = shortest_paths(episodes);
    const Score score = compute_score(trajectories, episodes);
    const MeanInterval& mean = score.mean("trajectory_length");
    EXPECT_NEAR(mean.mean, length, 0.005) << "two digits are published";
    EXPECT_LT(mean.low, length);
    EXPECT_GT(mean.high, length);
    EXPECT_EQ(score.mean("success").mean, 1);
    EXPECT_EQ(score.mean("spl").mean, 1);
    const auto read = parse_results(to_json(trajectories, episodes), "<memory>", episodes);
    EXPECT_EQ(to_json(read.trajectories, episodes), to_json(trajectories, episodes));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
