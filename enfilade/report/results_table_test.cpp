#include "enfilade/report/results_table.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/support/made_run.h"

namespace enfilade::report {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class ResultsTableTest : public ::testing::Test {
 protected:
  ResultsTable table(bool synthetic = false) const {
    const dataset::Dataset data(made_.data());
    const std::vector<std::filesystem::path> named{made_.run()};
    return make_table(score_runs(find_runs(named, data), data), synthetic);
  }
  void run(const std::string& agent, const std::string& split, int moves) const {
    made_.write_results(made_.run() / fmt::format("{}_{}.json", agent, split), moves);
  }
  testing::MadeRun made_;
};

TEST_F(ResultsTableTest, OneRunHasItsMeanAndTheBootstrapInterval) {
  run("random", "val_seen", 2);
  const ResultsTable made = table();
  ASSERT_EQ(made.rows.size(), 1U);
  const TableRow& row = made.rows[0];
  EXPECT_EQ(row.episodes, 6U);
  EXPECT_EQ(row.values[0].mean, 4) << "two moves of 2 m";
  EXPECT_EQ(row.values[1].mean, 3) << "the goals are 8 m and 6 m from the start: (4 + 2) / 2";
  EXPECT_EQ(row.values[2].mean, 0.5) << "2 m is nearer than 3 m, 4 m is not";
  EXPECT_EQ(row.values[1].low, 2) << "both draws may be the near path";
  EXPECT_EQ(row.values[1].high, 4);
}

TEST_F(ResultsTableTest, SeveralSeedsAreOneRowWithStudentsInterval) {
  run("student-1", "val_seen", 1);
  run("student-2", "val_seen", 2);
  run("student-3", "val_seen", 3);
  run("student-1", "val_unseen", 3);
  const ResultsTable made = table();
  ASSERT_EQ(made.rows.size(), 2U);
  EXPECT_EQ(made.rows[0].agent, "student");
  EXPECT_EQ(made.rows[0].runs.size(), 3U);
  // TL 2, 4, 6: mean 4, deviation 2; 4.303 * 2 / sqrt(3) = 4.9687 (4.303 has four digits).
  EXPECT_NEAR(made.rows[0].values[0].mean, 4, 1e-12);
  EXPECT_EQ(made.rows[0].values[0].low, 0) << "4 - 4.9687: no length";
  EXPECT_EQ(made.rows[0].values[2].high, 1) << "success 0, 0.5, 1: 0.5 + 1.24 is no share";
  EXPECT_NEAR(made.rows[0].values[0].high, 4 + 4.9687, 1e-3);
}

TEST(StudentInterval, FollowsTheTableOfTheDistribution) {
  const std::vector<double> two{0, 2};
  EXPECT_NEAR(student_interval(two).high, 1 + 12.706, 1e-3) << "one degree of freedom";
  // 1.984 for 100 degrees of freedom; mean 0.5, deviation sqrt(25.25 / 100) = 0.50249 of 101.
  std::vector<double> many;
  for (int i = 0; i < 101; ++i) many.push_back(i % 2);
  EXPECT_NEAR(student_interval(many).high - student_interval(many).mean, 1.984 * 0.5025 / 10.0499,
              1e-4);
  EXPECT_EQ(student_interval(std::vector{7.0}).high, 7);
}

TEST_F(ResultsTableTest, RowsGoBySplitThenAgent) {
  for (const char* split : {"val_unseen", "train", "val_seen"}) {
    run("random", split, 1);
    run("shortest", split, 4);
  }
  std::vector<std::string> order;
  for (const TableRow& row : table().rows) order.push_back(row.split + " " + row.agent);
  EXPECT_THAT(
      order, ::testing::ElementsAre("train shortest", "train random", "val_seen shortest",
                                    "val_seen random", "val_unseen shortest", "val_unseen random"));
}

TEST_F(ResultsTableTest, HiddenGoalsAreLeftOutAndSaidSo) {
  run("random", "val_seen", 1);
  run("random", "test", 1);
  const ResultsTable made = table();
  EXPECT_EQ(made.rows.size(), 1U);
  EXPECT_THAT(to_text(made), HasSubstr("Left out: random on test: the goals of this split are "
                                       "hidden."));
}

TEST_F(ResultsTableTest, NothingPublishedStandsBesideOtherData) {
  run("random", "val_seen", 1);
  EXPECT_FALSE(table().rows[0].published) << "6 episodes, not 1020";
  EXPECT_THAT(to_text(table(true)), HasSubstr("SYNTHETIC"));
  EXPECT_THAT(to_markdown(table(true)), HasSubstr("SYNTHETIC"));
  EXPECT_TRUE(nlohmann::json::parse(to_json(table(true)))["synthetic"].get<bool>());
  EXPECT_THAT(to_csv(table(true)), HasSubstr(",yes,"));
  EXPECT_THAT(to_text(table(false)), Not(HasSubstr("SYNTHETIC")));
}

TEST_F(ResultsTableTest, FormatsSayTheSame) {
  run("my|agent", "val_seen", 2);
  const ResultsTable made = table();
  EXPECT_THAT(to_text(made), HasSubstr("3.00 [2.00, 4.00]"));
  EXPECT_THAT(to_text(made), HasSubstr("50.0 [0.0, 100.0]"));
  EXPECT_THAT(to_markdown(made), HasSubstr("| val_seen | my\\|agent | 1 | 4.00 |"));
  EXPECT_THAT(to_csv(made), HasSubstr("\r\nmy|agent,val_seen,1,6,no,4,4,4,,3,2,4,,0.5,0,1,,"));
  const auto json = nlohmann::json::parse(to_json(made));
  EXPECT_EQ(json["rows"][0]["nav_error"]["high"], 4);
  EXPECT_EQ(json["rows"][0]["runs"][0], "my|agent");
  EXPECT_FALSE(json["rows"][0]["nav_error"].contains("published"));
}

TEST_F(ResultsTableTest, CsvHasAsManyCellsInEachLine) {
  run("a,\"b\"", "val_seen", 2);
  const std::string csv = to_csv(table());
  EXPECT_THAT(csv, StartsWith("agent,split,runs,episodes,synthetic,trajectory_length,"));
  EXPECT_THAT(csv, HasSubstr("\r\n\"a,\"\"b\"\"\",val_seen,"));
  const std::size_t first = csv.find("\r\n"), second = csv.find("\r\n", first + 2);
  const auto commas = [&csv](std::size_t from, std::size_t to) {
    return std::count(csv.begin() + static_cast<std::ptrdiff_t>(from),
                      csv.begin() + static_cast<std::ptrdiff_t>(to), ',');
  };
  EXPECT_EQ(commas(0, first) + 1, commas(first, second)) << "one comma is the agent's own";
}

TEST(RealData, PublishedFiguresStandBesideTheRandomAgents) {
  const auto data = dataset::Dataset::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real R2R to score";
  EXPECT_EQ(data->episodes("val_unseen").episodes.size(),
            published_row("random", "val_unseen")->episodes);
  EXPECT_FALSE(data->synthetic());
}

}  // namespace EN_UNIT
}  // namespace enfilade::report
