// Results of every benchmark, written and read back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>

#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"
#include "tests/support/graphs.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::HasSubstr;

constexpr ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

// One path of a square from v0 to v2, with instructions of these ids.
EpisodeSet episodes_of(Task task, const std::vector<std::string>& ids) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square());
  EpisodeSet set{"val", graph::GraphSet::of(std::move(graphs)), {}, {}, task};
  set.paths.push_back({7, ScanIndex(0), Radians(0), {v(0), v(1), v(2)}});
  for (std::size_t k = 0; k < ids.size(); ++k) set.episodes.push_back({ids[k], 0, k, "Go."});
  return set;
}

std::vector<Trajectory> walks(std::size_t n) {
  std::vector<Trajectory> all(n);
  for (std::size_t i = 0; i < n; ++i) {
    all[i].episode = i;
    all[i].points = {{v(0), Radians(0.5), Radians(0)}, {v(1), Radians(0.5), Radians(-0.25)}};
  }
  return all;
}

// What is read back, after a check that it is written the same again.
std::vector<Trajectory> round_trip(const std::vector<Trajectory>& written, const EpisodeSet& set,
                                   const std::string& expected) {
  const std::string text = to_json(written, set);
  EXPECT_THAT(text, HasSubstr(expected));
  auto read = parse_results(text, "r.json", set).trajectories;
  EXPECT_EQ(to_json(read, set), text);
  return read;
}

TEST(ResultsWriter, R2rAndWhatHasGrownOutOfIt) {
  for (const Task task : {Task::kR2r, Task::kR2rLast, Task::kR4r}) {
    const EpisodeSet set = episodes_of(task, {"7_0", "7_1"});
    const auto read =
        round_trip(walks(2), set,
                   R"({"instr_id": "7_0", "trajectory": [["v0", 0.5, 0], ["v1", 0.5, -0.25]]},)");
    EXPECT_EQ(read[1].points[1].elevation, Radians(-0.25));
  }
}

TEST(ResultsWriter, ATurningPointOrNull) {
  const EpisodeSet set = episodes_of(Task::kR2rBack, {"7_0", "7_1"});
  auto written = walks(2);
  written[0].turning_point = v(3);
  const auto read = round_trip(written, set, R"("midstop": "v3"})");
  EXPECT_EQ(read[0].turning_point, v(3));
  EXPECT_EQ(read[1].turning_point, std::nullopt);
}

TEST(ResultsWriter, RxrsOwnNumberBesideTheId) {
  const EpisodeSet set = episodes_of(Task::kRxr, {"7_26", "odd"});
  round_trip(walks(2), set, R"({"instr_id": "7_26", "instruction_id": 26, "trajectory": [["v0")");
  EXPECT_THAT(to_json(walks(2), set), HasSubstr(R"({"instr_id": "odd", "trajectory")"));
}

// Test lines of RxR have no path_id, and the same lines with their goals may have one.
TEST(Results, RxrsIdIsKnownWithThePathOrWithoutIt) {
  const auto ids_read = [](const char* known, const std::string& id) {
    const EpisodeSet set = episodes_of(Task::kRxr, {known});
    return parse_results(R"([{)" + id + R"(, "trajectory": ["v0"]}])", "r.json", set)
        .trajectories.size();
  };
  for (const char* known : {"150_1501", "1501"}) {
    for (const char* id :
         {R"("instr_id": "150_1501")", R"("instr_id": "1501")",
          R"("instruction_id": 1501, "instr_id": "1501")", R"("instruction_id": 1501)"}) {
      EXPECT_EQ(ids_read(known, id), 1U) << known << " " << id;
    }
  }
  for (const char* id : {R"("instr_id": "15_1501")", R"("instr_id": "150_150")",
                         R"("instr_id": "150")", R"("instr_id": "_1501")"}) {
    EXPECT_THROW(ids_read("150_1501", id), InvalidInput) << id;
  }
  const EpisodeSet r2r = episodes_of(Task::kR2r, {"150_1501"});
  EXPECT_THROW(parse_results(R"([{"instr_id": "1501", "trajectory": ["v0"]}])", "r.json", r2r),
               InvalidInput);
  const EpisodeSet once = episodes_of(Task::kRxr, {"1501"});
  EXPECT_THROW(parse_results(R"([{"instr_id": "1501", "trajectory": ["v0"]},
                                 {"instr_id": "150_1501", "trajectory": ["v0"]}])",
                             "r.json", once),
               InvalidInput)
      << "one episode, named in two ways";
}

TEST(ResultsWriter, ReveriesObjectAsANumberWhereItIsOne) {
  const EpisodeSet set = episodes_of(Task::kReverie, {"7_66_0", "7_66_1", "7_66_2"});
  auto written = walks(3);
  written[0].object = "66";
  written[1].object = "066";
  const auto read = round_trip(written, set, R"("predObjId": 66})");
  EXPECT_THAT(to_json(written, set), HasSubstr(R"("predObjId": "066"})"));
  EXPECT_THAT(to_json(written, set), HasSubstr(R"("predObjId": null})"));
  EXPECT_EQ(read[0].object, "66");
  EXPECT_EQ(read[1].object, "066");
  EXPECT_EQ(read[2].object, "");
}

TEST(ResultsWriter, CvdnsNumberOrHamtsId) {
  EpisodeSet set = episodes_of(Task::kCvdn, {"1000", "game-5"});
  const auto read = round_trip(walks(2), set, R"({"inst_idx": 1000, "trajectory": [["v0")");
  EXPECT_THAT(to_json(walks(2), set), HasSubstr(R"({"instr_id": "game-5", "trajectory")"));
  EXPECT_EQ(read.size(), 2U);
}

TEST(ResultsWriter, SoonsPointInsideTheTrajectory) {
  const EpisodeSet set = episodes_of(Task::kSoon, {"3-0_0", "3-0_1"});
  auto written = walks(2);
  written[0].point = SpherePoint{0.25, 0.5};
  const auto read = round_trip(
      written, set, R"("v1", 0.5, -0.25]], "obj_heading": [0.25], "obj_elevation": [0.5]}})");
  EXPECT_THAT(to_json(written, set), HasSubstr(R"("obj_heading": null, "obj_elevation": null}})"));
  EXPECT_EQ(read[0].point, written[0].point);
  EXPECT_EQ(read[1].point, std::nullopt);
}

TEST(ResultsWriter, PointsAreWrapped) {
  constexpr double kPi = std::numbers::pi;
  EXPECT_EQ(sphere_point({Radians(kPi), Radians(0)}), (SpherePoint{0.5, 0.5}));
  EXPECT_EQ(sphere_point({Radians(-kPi / 2), Radians(-kPi / 2)}), (SpherePoint{0.75, 0.25}));
  EXPECT_EQ(sphere_point({Radians(2 * kPi), Radians(0)}).heading, 0);
}

TEST(ResultsWriter, AnotherTextIsRefused) {
  EpisodeSet set = episodes_of(Task::kR2r, {"7\xff"});
  EXPECT_THROW(to_json(walks(1), set), ArgumentError);
  auto walk = walks(1);
  walk[0].point = SpherePoint{std::nan(""), 0};
  EXPECT_THROW(to_json(walk, episodes_of(Task::kSoon, {"1-1_0"})), ArgumentError);
}

TEST(ResultsWriter, WritesTensOfThousandsOfTrajectoriesFast) {
  std::vector<std::string> ids;
  for (int i = 0; i < 45'000; ++i) ids.push_back("7_" + std::to_string(i));
  const EpisodeSet set = episodes_of(Task::kReverie, ids);
  auto written = walks(ids.size());
  for (Trajectory& one : written) {
    for (int k = 0; k < 20; ++k) {
      one.points.push_back({v(1), Radians(0.1 * k), Radians(0)});
      one.points.push_back({v(1), Radians(0.1 * k), Radians(0)});
    }
  }
  const auto before = std::chrono::steady_clock::now();
  const std::string text = to_json(written, set);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
  RecordProperty("seconds", std::to_string(took.count()));
  EXPECT_GT(text.size(), 20'000'000U);
  EXPECT_LT(took.count(), 20) << "1.9 million points; far from a second on any machine";
}

TEST(Results, APartOfASplitOnPurpose) {
  const EpisodeSet set = episodes_of(Task::kR2r, {"7_0", "7_1", "7_2"});
  const std::string text = R"([{"instr_id": "7_2", "trajectory": ["v0", "v1"]},
                               {"instr_id": "7_0", "trajectory": ["v0"]}])";
  EXPECT_THROW(parse_results(text, "r.json", set), InvalidInput);
  Results results = parse_results(text, "r.json", set, Coverage::kPart);
  const EpisodeSet part = part_of(set, results.trajectories);
  ASSERT_EQ(part.episodes.size(), 2U);
  EXPECT_EQ(part.episodes[0].instruction_id, "7_0");
  EXPECT_EQ(part.episodes[1].instruction_id, "7_2");
  EXPECT_EQ(results.trajectories[1].points.size(), 2U);
  const ScoreTable score = compute_score(results.trajectories, part);
  EXPECT_DOUBLE_EQ(score.mean("nav_error").mean, 3);
  EXPECT_THROW(parse_results("[]", "r.json", set, Coverage::kPart), InvalidInput)
      << "nothing is no part";
  EXPECT_THROW(parse_results(R"([{"instr_id": "9_9", "trajectory": ["v0"]}])", "r.json", set,
                             Coverage::kPart),
               InvalidInput);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
