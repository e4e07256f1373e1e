// Tables of other benchmarks than R2R, on hand-made files.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "enfilade/report/results_table.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/scorer.h"
#include "tests/support/made_run.h"

namespace enfilade::report {
namespace EN_UNIT {

using tasks::Task;
using ::testing::HasSubstr;
using ::testing::Not;

// A row v0 .. v4, 2 m apart: REVERIE, RxR, CVDN and SOON from v0 to v4.
class TaskTableTest : public ::testing::Test {
 protected:
  TaskTableTest() {
    for (const char* name : {"reverie", "rxr", "cvdn", "soon", "r4r"}) {
      make_folder(made_.data() / name);
    }
    write_file_atomically(made_.data() / "reverie/REVERIE_val_unseen.json", R"([
{"id": "1_5", "path_id": 1, "objId": 5, "scan": "row", "heading": 0, "path": ["v0", "v1", "v2", "v3", "v4"],
 "instructions": ["Find it."]},
{"id": "2_5", "path_id": 2, "objId": 5, "scan": "row", "heading": 0, "path": ["v0", "v1", "v2", "v3", "v4"],
 "instructions": ["Look at it."]}])");
    write_file_atomically(made_.data() / "reverie/BBoxes.json",
                          R"({"row_v4": {"5": {"name": "chair",
      "visible_pos": [12], "bbox2d": [[1, 2, 3, 4]]}}})");
    std::string guide;
    for (int id = 1; id <= 4; ++id) {
      guide += fmt::format(
          R"({{"path_id": 1, "split": "val_unseen", "scan": "row", "heading": 0, "path": ["v0", "v1", "v2"],)"
          R"( "instruction_id": {}, "annotator_id": 1, "language": "{}", "instruction": "Go.",)"
          R"( "timed_instruction": [], "edit_distance": 0}})"
          "\n",
          id, id == 4 ? "hi-IN" : "en-IN");
    }
    write_file_atomically(made_.data() / "rxr/rxr_val_unseen_guide.jsonl", guide);
  }

  void write(const std::string& name, const std::string& text) const {
    write_file_atomically(made_.run() / name, text);
  }
  ResultsTable table(Task task, bool synthetic = true) const {
    const dataset::Dataset data(made_.data());
    const std::vector<std::filesystem::path> named{made_.run()};
    return make_table(score_runs(find_runs(named, data, tasks::benchmark(task)), data), synthetic);
  }
  testing::MadeRun made_;
};

const char* const kFound = R"([
{"instr_id": "1_5_0", "trajectory": ["v0", "v1", "v2", "v3", "v4"], "predObjId": 5},
{"instr_id": "2_5_0", "trajectory": ["v0", "v1"], "predObjId": 9}])";

TEST_F(TaskTableTest, ReverieHasItsColumnsHeadlineFirst) {
  write("random_val_unseen.json", kFound);
  const ResultsTable made = table(Task::kReverie);
  ASSERT_EQ(made.rows.size(), 1U);
  std::vector<double> means;
  for (const auto& value : made.rows[0].values) means.push_back(value.mean);
  EXPECT_EQ(means, (std::vector{0.5, 0.5, 0.5, 0.5, 0.5})) << "SR OSR SPL RGS RGSPL, as shares";
  EXPECT_THAT(to_text(made), HasSubstr("SR (%)"));
  EXPECT_THAT(to_text(made), HasSubstr("REVERIE, scored as official (YuankaiQi/REVERIE"));
  const auto json = nlohmann::json::parse(to_json(made));
  EXPECT_EQ(json["task"], "reverie");
  EXPECT_EQ(json["columns"][3]["metric"], "rgs");
  EXPECT_EQ(json["rows"][0]["rgs"]["mean"], 0.5);
  EXPECT_TRUE(json["published"].empty()) << "nothing beside model homes";
  EXPECT_THAT(to_csv(made), HasSubstr(",rgspl,rgspl_low,rgspl_high,rgspl_published\r\n"));
  EXPECT_THAT(to_markdown(made), HasSubstr("| RGSPL (%) |"));
}

// The start is the end of R2R-Back's way: it counts from the turning point on.
TEST_F(TaskTableTest, TheOracleOfR2rBackTurnsFirst) {
  make_folder(made_.data() / "r2r-back");
  write_file_atomically(made_.data() / "r2r-back/R2R_val_unseen.json", R"([
{"path_id": 1, "scan": "row", "heading": 0, "distance": 16, "midstop": "v4",
 "path": ["v0", "v1", "v2", "v3", "v4", "v3", "v2", "v1", "v0"],
 "instructions": ["Go and come.", "Go on.", "Come."]}])");
  write("walker_val_unseen.json", R"([
{"instr_id": "1_0", "trajectory": ["v0", "v1", "v2", "v3", "v4"], "midstop": "v4"},
{"instr_id": "1_1", "trajectory": ["v0", "v1", "v2", "v3", "v4", "v3", "v2", "v1", "v2"], "midstop": "v4"},
{"instr_id": "1_2", "trajectory": ["v0", "v1", "v2"], "midstop": "v4"}])");
  const dataset::Dataset data(made_.data());
  const std::vector<std::filesystem::path> named{made_.run()};
  const auto runs = score_runs(find_runs(named, data, tasks::benchmark(Task::kR2rBack)), data);
  ASSERT_EQ(runs.runs.size(), 1U);
  const tasks::ScoreTable& scores = runs.runs[0].scores.ours;
  EXPECT_EQ(scores.value(0, "oracle_error"), 6) << "it stays where it turns, which begins at v3";
  EXPECT_EQ(scores.value(0, "oracle_success"), 0);
  EXPECT_EQ(scores.value(1, "oracle_error"), 2) << "it came near, and went away again";
  EXPECT_EQ(scores.value(1, "oracle_success"), 1);
  EXPECT_EQ(scores.value(2, "oracle_error"), 4) << "never at the turning point: where it ends";
}

TEST_F(TaskTableTest, TheTaskIsFoundFromTheResults) {
  write("random_val_unseen.json", kFound);
  const std::vector<std::filesystem::path> named{made_.run()};
  EXPECT_EQ(find_benchmark_of_runs(named), &tasks::benchmark(Task::kReverie));
  const std::vector<std::filesystem::path> none{made_.data() / "connectivity"};
  EXPECT_EQ(find_benchmark_of_runs(none), nullptr);
  EXPECT_THROW(find_runs(named, dataset::Dataset(made_.data()), tasks::benchmark(Task::kSoon)),
               LookupError)
      << "no split of SOON";
}

TEST_F(TaskTableTest, TheGoalOfReverieIsWhereTheObjectIsSeen) {
  write("random_val_unseen.json", kFound);
  const dataset::Dataset data(made_.data());
  const std::vector<std::filesystem::path> named{made_.run()};
  const auto runs = score_runs(find_runs(named, data, tasks::benchmark(Task::kReverie)), data);
  const tasks::ScoreTable& scores = runs.runs.at(0).scores.ours;
  EXPECT_EQ(scores.value(0, "success"), 1);
  EXPECT_EQ(scores.value(1, "success"), 0);
  EXPECT_EQ(scores.value(1, "nav_error"), 6);
}

TEST_F(TaskTableTest, WhatOthersPublishedStandsBelowRealDataOnly) {
  write("random_val_unseen.json", kFound);
  const std::string text = to_text(table(Task::kReverie, false));
  EXPECT_THAT(text, HasSubstr("Published, val unseen: NaviLLM: SR 42.15, SPL 35.68 (README of "));
  EXPECT_THAT(to_text(table(Task::kReverie)), Not(HasSubstr("NaviLLM")));
}

TEST_F(TaskTableTest, RxrHasRowsByLanguageAndBothNdtws) {
  std::string text = "[";
  for (int id = 1; id <= 4; ++id) {
    text += fmt::format(R"({}{{"instr_id": "1_{}", "trajectory": ["v0", "v0"{}]}})",
                        id == 1 ? "" : ",", id, id == 4 ? "" : R"(, "v1", "v2")");
  }
  write("random_val_unseen.json", text + "]");
  const ResultsTable made = table(Task::kRxr);
  ASSERT_EQ(made.rows.size(), 3U);
  EXPECT_EQ(made.rows[0].language, "");
  EXPECT_EQ(made.rows[1].language, "en-IN");
  EXPECT_EQ(made.rows[1].episodes, 3U);
  EXPECT_EQ(made.rows[2].language, "hi-IN");
  EXPECT_EQ(made.rows[0].values[0].mean, 0.75);
  EXPECT_EQ(made.rows[2].values[0].mean, 0);
  const auto json = nlohmann::json::parse(to_json(made));
  EXPECT_EQ(json["rows"][1]["ndtw_collapsed"]["mean"], 1) << "the turn at the start is no move";
  EXPECT_EQ(json["rows"][1]["ndtw"]["mean"], 1) << "a turn at the start costs nothing either way";
  EXPECT_THAT(to_text(made), HasSubstr("* Turns on the spot are taken once"));
  EXPECT_THAT(to_csv(made), HasSubstr("agent,split,language,runs"));
}

TEST(TableColumns, NameMetricsThatTheirScorersHave) {
  for (const tasks::Benchmark& one : tasks::benchmarks()) {
    const tasks::Scorer& ours = one.continuous() ? one.scorers.front() : tasks::own_scorer();
    const tasks::Scorer& by_task = one.scorer(one.table_scorer);
    bool success = false;
    for (const TableColumn& column : table_columns(one)) {
      success = success || column.metric == "success";
      EXPECT_NO_THROW(column.scored.empty() ? ours.place_of(column.metric)
                                            : by_task.place_of(column.scored));
    }
    EXPECT_TRUE(success) << one.name;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::report
