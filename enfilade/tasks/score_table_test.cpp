#include "enfilade/tasks/score_table.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
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

TEST(ScoreTable, MeansAreOfTheEpisodes) {
  const EpisodeSet episodes = row_episodes(1);
  const ScoreTable score =
      compute_score({straight(0, 3), straight(1, 1), straight(2, 4)}, episodes);
  ASSERT_EQ(score.episodes, 3U);
  EXPECT_EQ(score.value(1, "nav_error"), 4);
  EXPECT_EQ(score.mean("nav_error").mean, 2) << "(0 + 4 + 2) / 3";
  EXPECT_EQ(score.mean("trajectory_length").mean, 10.0 / 3);
  EXPECT_EQ(score.mean("success").mean, 2.0 / 3);
  EXPECT_EQ(score.mean("success").low, score.mean("success").high) << "one path, no other to draw";
  EXPECT_THROW(score.mean("sr"), LookupError);
}

TEST(ScoreTable, PutsTrajectoriesInTheOrderOfEpisodes) {
  const EpisodeSet episodes = row_episodes(1);
  const ScoreTable score =
      compute_score({straight(2, 4), straight(0, 3), straight(1, 1)}, episodes);
  EXPECT_EQ(score.value(0, "nav_error"), 0);
  EXPECT_EQ(score.value(1, "nav_error"), 4);
  EXPECT_EQ(score.value(2, "nav_error"), 2);
}

TEST(ScoreTable, ThreadsChangeNothing) {
  const EpisodeSet episodes = row_episodes(500);
  const auto trajectories = random_trajectories(episodes);
  ScoreOptions options;
  options.threads = 1;
  const std::string one = to_json(compute_score(trajectories, episodes, options), true);
  options.threads = 4;
  EXPECT_EQ(to_json(compute_score(trajectories, episodes, options), true), one);
}

TEST(ScoreTable, RefusesWhatCannotBeScored) {
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

TEST(ScoreTable, HiddenGoalsCannotBeScored) {
  EpisodeSet episodes = row_episodes(2);
  EXPECT_FALSE(goals_hidden(episodes));
  episodes.paths[1].viewpoints.resize(1);
  EXPECT_TRUE(goals_hidden(episodes));
  EXPECT_THROW(compute_score(random_trajectories(episodes), episodes), ArgumentError);
}

TEST(ScoreTable, JsonHasEveryFieldByName) {
  const EpisodeSet episodes = row_episodes(20);
  const ScoreTable score = compute_score(random_trajectories(episodes), episodes);
  const auto json = nlohmann::json::parse(to_json(score, true));
  EXPECT_EQ(json["split"], "val");
  EXPECT_EQ(json["episodes"], 60);
  EXPECT_EQ(json["options"]["success_distance"], 3.0);
  for (const MetricField& field : kMetricFields) {
    const MeanInterval& mean = score.mean(field.name);
    EXPECT_EQ(json["means"][field.name]["mean"], mean.mean) << field.name;
    EXPECT_EQ(json["means"][field.name]["low"], mean.low) << field.name;
    EXPECT_EQ(json["means"][field.name]["high"], mean.high) << field.name;
    EXPECT_EQ(json["per_episode"]["19_2"][field.name], score.value(59, field.name));
  }
  EXPECT_FALSE(nlohmann::json::parse(to_json(score)).contains("per_episode"));
}

TEST(ScoreTable, JsonOfWhatIsOutOfReachIsNull) {
  const EpisodeSet episodes = row_episodes(1);
  std::vector<Trajectory> trajectories{straight(0, 3), straight(1, 3), straight(2, 1)};
  trajectories[2].points[0].viewpoint = ViewpointIndex(4);
  const ScoreTable score = compute_score(trajectories, episodes);
  const auto json = nlohmann::json::parse(to_json(score, true));
  EXPECT_TRUE(json["per_episode"]["0_2"]["nav_error"].is_null());
  EXPECT_TRUE(json["means"]["nav_error"]["mean"].is_null());
  EXPECT_EQ(json["means"]["success"]["mean"], 2.0 / 3);
}

TEST(ScoreTable, TableIsForReading) {
  const EpisodeSet episodes = row_episodes(1);
  const std::vector<Trajectory> trajectories{straight(0, 3), straight(1, 1), straight(2, 4)};
  ScoreOptions options;
  const std::string table = to_table(compute_score(trajectories, episodes, options));
  EXPECT_THAT(table, HasSubstr("val: 3 episodes\n"));
  EXPECT_THAT(table, HasSubstr("TL (m)        3.33   [3.33, 3.33]\n"));
  EXPECT_THAT(table, HasSubstr("SR (%)        66.7   [66.7, 66.7]\n"));
  EXPECT_THAT(table, HasSubstr("steps         1.67"));
  options.bootstrap_samples = 0;
  const ScoreTable plain = compute_score(trajectories, episodes, options);
  EXPECT_THAT(to_table(plain), HasSubstr("NE (m)        2.00\n"));
  EXPECT_FALSE(nlohmann::json::parse(to_json(plain))["means"]["success"].contains("low"));
}

TEST(ScoreTable, TableShowsTheSplThatWasAskedFor) {
  EpisodeSet episodes = row_episodes(1);
  // A reference with a detour: 8 m for a shortest path of 4 m, which the trajectories take.
  for (const std::size_t v : {1U, 2U}) episodes.paths[0].viewpoints.emplace_back(v);
  const auto taken = {straight(0, 3), straight(1, 3), straight(2, 3)};
  const ScoreTable score = compute_score(taken, episodes);
  EXPECT_EQ(score.mean("spl").mean, 1);
  EXPECT_EQ(score.mean("spl_refpath").mean, 1) << "8 / max(4, 8)";
  EXPECT_THAT(to_table(score), Not(HasSubstr("SPL*")));
  EXPECT_THAT(to_table(score, SplLength::kReference),
              HasSubstr("* against the length of the reference path"));
}

// \name What to_json() and to_table() gave before there was one type for all scorers
// @{
constexpr const char* kOwnJson =
    R"({"split":"val","episodes":2,"options":{"success_distance":3.0,"bootstrap_samples":1000,)"
    R"("bootstrap_seed":1,"confidence":0.95},"means":{"steps":{"mean":1.5,"low":1.0,)"
    R"("high":2.0},"moves":{"mean":1.0,"low":0.0,"high":2.0},"trajectory_length":{"mean":2.0,)"
    R"("low":0.0,"high":4.0},"reference_length":{"mean":4.0,"low":4.0,"high":4.0},)"
    R"("shortest":{"mean":4.0,"low":4.0,"high":4.0},"nav_error":{"mean":2.0,"low":0.0,)"
    R"("high":4.0},"oracle_error":{"mean":2.0,"low":0.0,"high":4.0},"success":{"mean":0.5,)"
    R"("low":0.0,"high":1.0},"oracle_success":{"mean":0.5,"low":0.0,"high":1.0},)"
    R"("spl":{"mean":0.5,"low":0.0,"high":1.0},"spl_refpath":{"mean":0.5,"low":0.0,"high":1.0},)"
    R"("dtw":{"mean":3.0,"low":0.0,"high":6.0},"ndtw":{"mean":0.756708559516296,)"
    R"("low":0.513417119032592,"high":1.0},"sdtw":{"mean":0.5,"low":0.0,"high":1.0},)"
    R"("dtw_collapsed":{"mean":3.0,"low":0.0,"high":6.0},)"
    R"("ndtw_collapsed":{"mean":0.756708559516296,"low":0.513417119032592,"high":1.0},)"
    R"("sdtw_collapsed":{"mean":0.5,"low":0.0,"high":1.0},)"
    R"("coverage":{"mean":0.7961690428580531,"low":0.5923380857161062,"high":1.0},)"
    R"("cls":{"mean":0.6480845214290265,"low":0.2961690428580531,"high":1.0}},)"
    R"("per_episode":{"0_0":{"steps":2.0,"moves":2.0,"trajectory_length":4.0,)"
    R"("reference_length":4.0,"shortest":4.0,"nav_error":0.0,"oracle_error":0.0,"success":1.0,)"
    R"("oracle_success":1.0,"spl":1.0,"spl_refpath":1.0,"dtw":0.0,"ndtw":1.0,"sdtw":1.0,)"
    R"("dtw_collapsed":0.0,"ndtw_collapsed":1.0,"sdtw_collapsed":1.0,"coverage":1.0,"cls":1.0},)"
    R"("1_0":{"steps":1.0,"moves":0.0,"trajectory_length":0.0,"reference_length":4.0,)"
    R"("shortest":4.0,"nav_error":4.0,"oracle_error":4.0,"success":0.0,"oracle_success":0.0,)"
    R"("spl":0.0,"spl_refpath":0.0,"dtw":6.0,"ndtw":0.513417119032592,"sdtw":0.0,)"
    R"("dtw_collapsed":6.0,"ndtw_collapsed":0.513417119032592,"sdtw_collapsed":0.0,)"
    R"("coverage":0.5923380857161062,"cls":0.2961690428580531}}})";
constexpr const char* kPublicJson =
    R"({"task":"r2r","split":"val","scorer":"r4r_public",)"
    R"("source":"google-research/google-research r4r/{cls,dtw}.py","episodes":2,)"
    R"("means":{"dtw":{"mean":3.0,"low":0.0,"high":6.0},"ndtw":{"mean":0.756708559516296,)"
    R"("low":0.513417119032592,"high":1.0},"sdtw":{"mean":0.5,"low":0.0,"high":1.0}},)"
    R"("per_episode":{"0_0":{"dtw":0.0,"ndtw":1.0,"sdtw":1.0,"cls":1.0},"1_0":{"dtw":6.0,)"
    R"("ndtw":0.513417119032592,"sdtw":0.0,"cls":null}}})";
constexpr const char* kFloorJson =
    R"({"split":"val_unseen","episodes":2,"trajectories":2,"means":{"path_length":{"mean":3.0,)"
    R"("low":2.0,"high":4.0},"distance_to_goal":{"mean":0.0,"low":0.0,"high":0.0},)"
    R"("success":{"mean":0.5,"low":0.0,"high":1.0},"oracle_success":{"mean":0.0,"low":0.0,)"
    R"("high":0.0},"spl":{"mean":null,"low":null,"high":null},"ndtw":{"mean":0.25,"low":0.0,)"
    R"("high":0.5},"sdtw":{"mean":0.0,"low":0.0,"high":0.0},"ndtw_fastdtw":{"mean":0.0,)"
    R"("low":0.0,"high":0.0},"steps_taken":{"mean":1.5,"low":0.0,"high":3.0},)"
    R"("collisions":{"mean":null,"low":null,"high":null}},)"
    R"("per_episode":{"1":{"path_length":4.0,"distance_to_goal":0.0,"success":1.0,)"
    R"("oracle_success":0.0,"spl":1.0,"ndtw":0.5,"sdtw":0.0,"ndtw_fastdtw":0.0,)"
    R"("steps_taken":0.0,"collisions":null},"2":{"path_length":2.0,"distance_to_goal":0.0,)"
    R"("success":0.0,"oracle_success":0.0,"spl":null,"ndtw":0.0,"sdtw":0.0,"ndtw_fastdtw":0.0,)"
    R"("steps_taken":3.0,"collisions":null}}})";
constexpr const char* kFloorTable = R"(2 episodes of 2 trajectories
                           mean   95 % interval
TL (m)                     3.00   [2.00, 4.00]
NE (m)                     0.00   [0.00, 0.00]
SR (%)                    50.00   [0.00, 100.00]
OSR (%)                    0.00   [0.00, 0.00]
nDTW (%)                  25.00   [0.00, 50.00]
SDTW (%)                   0.00   [0.00, 0.00]
nDTW, by fastdtw (%)       0.00   [0.00, 0.00]
actions                    1.50   [0.00, 3.00]
)";
// @}

// As files have it, indented.
std::string indented(const char* json) {
  return nlohmann::ordered_json::parse(json).dump(1) + "\n";
}

// Two paths with an instruction each: one is walked, the other agent stays where it is.
ScoreTable two_episodes(std::string_view scorer) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::connectivity(
      "row", {{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {6, 0, 0}, {0, 9, 0}}, {{0, 1}, {1, 2}, {2, 3}}));
  Annotations annotations{"val", "val.json", {}};
  for (const std::int64_t id : {0, 1}) {
    annotations.paths.push_back({id, "row", Radians(0), {"v0", "v1", "v2"}, 4.0, {"Go."}});
  }
  const auto episodes = make_episodes(annotations, graph::GraphSet::of(std::move(graphs)));
  std::vector<Trajectory> trajectories{straight(0, 3), straight(1, 2)};
  trajectories[1].points[1].viewpoint = ViewpointIndex(0);
  return compute_score(trajectories, episodes, benchmark("r2r").scorer(scorer));
}

ContinuousEpisodes floor_episodes(std::size_t count, std::size_t trajectories) {
  ContinuousEpisodes episodes;
  episodes.split = "val_unseen";
  for (std::size_t k = 0; k < count; ++k) {
    ContinuousEpisode& one = episodes.episodes.emplace_back();
    one.id = static_cast<std::int64_t>(k + 1);
    one.trajectory_id = static_cast<std::int64_t>(std::min(k, trajectories - 1));
  }
  return episodes;
}

ScoreTable floor_table(const std::vector<ContinuousScore>& scores, std::size_t trajectories) {
  std::vector<ContinuousResult> walks(scores.size());
  std::vector<double> values;
  for (std::size_t k = 0; k < scores.size(); ++k) {
    walks[k].episode = k;
    for (const double value : vlnce_values(scores[k])) values.push_back(value);
  }
  const Benchmark& r2r_ce = benchmark("r2r-ce");
  return make_score_table(r2r_ce, r2r_ce.scorer("vlnce"), walks,
                          floor_episodes(scores.size(), trajectories), std::move(values));
}

ScoreTable two_walks() {
  std::vector<ContinuousScore> scores(2);
  scores[0].success = scores[0].spl = 1;
  scores[0].path_length = 4;
  scores[0].ndtw = 0.5;
  scores[1].spl = std::numeric_limits<double>::quiet_NaN();
  scores[1].path_length = 2;
  scores[1].steps_taken = 3;
  return floor_table(scores, 2);
}

TEST(ScoreTable, JsonAndTablesAreWhatTheyWere) {
  EXPECT_EQ(to_json(two_episodes({}), true), indented(kOwnJson));
  EXPECT_EQ(to_json(two_episodes("r4r_public"), true), indented(kPublicJson));
  EXPECT_EQ(to_json(two_walks(), true), indented(kFloorJson));
  EXPECT_EQ(to_table(two_walks()), kFloorTable);
}

TEST(ScoreTable, NamesTheFloorOfItsDistances) {
  ScoreTable table = two_walks();
  table.floor = "habitat 0.3.3";
  EXPECT_THAT(to_table(table), HasSubstr("floor                 habitat 0.3.3\n"));
  for (const std::string& json : {to_json(table), to_record(table)}) {
    EXPECT_THAT(nlohmann::json::parse(json).at("floor"), "habitat 0.3.3");
    EXPECT_EQ(from_json(json).floor, "habitat 0.3.3");
  }
  EXPECT_EQ(from_json(to_json(two_walks())).floor, "");  // as files from before have it
}

void expect_same(const ScoreTable& read, const ScoreTable& table) {
  EXPECT_EQ(read.benchmark, table.benchmark);
  EXPECT_EQ(read.scorer, table.scorer);
  EXPECT_EQ(read.split, table.split);
  EXPECT_EQ(read.episodes, table.episodes);
  ASSERT_EQ(read.means.size(), table.means.size());
  for (std::size_t k = 0; k < read.means.size(); ++k) {
    EXPECT_THAT(read.means[k].mean, ::testing::NanSensitiveDoubleEq(table.means[k].mean));
    EXPECT_THAT(read.means[k].low, ::testing::NanSensitiveDoubleEq(table.means[k].low));
    EXPECT_THAT(read.means[k].high, ::testing::NanSensitiveDoubleEq(table.means[k].high));
  }
}

TEST(ScoreTable, JsonOfEveryFormIsReadBackWithItsScorer) {
  for (const ScoreTable& table : {two_episodes({}), two_episodes("r4r_public"), two_walks()}) {
    const ScoreTable read = from_json(to_json(table, true));
    expect_same(read, table);
    EXPECT_EQ(read.ids, table.ids);
    EXPECT_THAT(read.values, ::testing::Pointwise(::testing::NanSensitiveDoubleEq(), table.values));
    EXPECT_EQ(to_json(read, true), to_json(table, true));
    const std::string record = to_record(table);
    expect_same(from_json(record), table);
    EXPECT_EQ(to_record(from_json(record)), record);
    EXPECT_THAT(record, HasSubstr(fmt::format("\"scorer\":\"{}\"", table.scorer->name)));
    EXPECT_THAT(record, Not(HasSubstr("\n")));
  }
  // As a database has them of walks from before there was ETPNav's scorer beside.
  const ScoreTable rxr = from_json(
      R"({"task":"rxr-ce","scorer":"vlnce","split":"test","episodes":1,"trajectories":1,"means":{}})");
  EXPECT_EQ(rxr.benchmark->name, "rxr-ce");
  EXPECT_TRUE(std::isnan(rxr.mean("ndtw").mean));
}

TEST(ScoreTable, OtherJsonIsRefused) {
  EXPECT_THROW(from_json("[]"), InvalidInput);
  EXPECT_THROW(from_json("{"), InvalidInput);
  EXPECT_THROW(from_json(R"({"task": "r3r"})"), LookupError);
  EXPECT_THROW(from_json(R"({"task": "r2r", "scorer": "gone"})"), LookupError);
}

TEST(ScoreTable, WalksAreDrawnByTrajectories) {
  std::vector<ContinuousScore> scores(3);
  scores[0].success = scores[1].success = 1;
  for (ContinuousScore& one : scores) one.path_length = 4;
  const ScoreTable table = floor_table(scores, 3);
  EXPECT_EQ(table.groups, 3U);
  const ScoreTable two = floor_table({scores[0], scores[1], scores[2]}, 2);
  EXPECT_EQ(two.groups, 2U);
  EXPECT_DOUBLE_EQ(two.mean("path_length").mean, 4);
  EXPECT_DOUBLE_EQ(two.mean("success").mean, 2.0 / 3);
  // The second trajectory alone may be drawn twice: half of its walks succeed.
  EXPECT_DOUBLE_EQ(two.mean("success").low, 0.5);
  EXPECT_DOUBLE_EQ(two.mean("success").high, 1);
  EXPECT_THAT(to_table(two), Not(HasSubstr("coll")));
  scores[0].collisions = scores[1].collisions = scores[2].collisions = 2;
  EXPECT_THAT(to_table(floor_table(scores, 2)), HasSubstr("collisions"));
  EXPECT_THROW(floor_table({}, 1), ArgumentError);
}

TEST(ScoreTable, OwnScorerTakesTheGoalThatThereIs) {
  EpisodeSet episodes = row_episodes(1);
  episodes.task = Task::kReverie;
  episodes.paths[0].goal = SeenObject{5, {ViewpointIndex(1)}};
  const ScoreTable table =
      compute_score({straight(0, 3), straight(1, 1), straight(2, 2)}, episodes, own_scorer());
  EXPECT_EQ(table.benchmark->name, "reverie");
  EXPECT_EQ(table.value(0, "success"), 0) << "at the end of the path, from where it is not seen";
  EXPECT_EQ(table.value(0, "oracle_success"), 1);
  EXPECT_EQ(table.value(1, "nav_error"), 2);
  EXPECT_EQ(table.value(2, "success"), 1);
  EXPECT_EQ(metrics_of(table, 2).nav_error, 0);
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

TEST(ScoreTable, OfRealShortestPathsIsThePapersRow) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real annotations";
  const auto graphs = graph::GraphSet::open(data->connectivity());
  // The paper's table 1, row Shortest.
  for (const auto& [split, length] :
       {std::pair{"val_seen", 10.19}, std::pair{"val_unseen", 9.48}}) {
    const EpisodeSet episodes =
        make_episodes(load_annotations(data->annotations(split), split), graphs);
    const auto trajectories = shortest_paths(episodes);
    const ScoreTable score = compute_score(trajectories, episodes);
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
